#include "firmware/keep/checkpoint.hpp"

#include <pb_decode.h>
#include <pb_encode.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>

#include "firmware/keep/checkpoint.pb.h"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::firmware {
namespace {

using Message = spindle_twin_firmware_Checkpoint;
using Field = const pb_field_t*;

// nanopb calls these back with the `arg` that attach() gives them.

bool encode_text(pb_ostream_t* stream, Field field, void* const* arg) {
  const auto& text = *static_cast<const std::string*>(*arg);
  return pb_encode_tag_for_field(stream, field) &&
         pb_encode_string(stream, reinterpret_cast<const pb_byte_t*>(text.data()), text.size());
}

bool encode_numbers(pb_ostream_t* stream, Field field, void* const* arg) {
  const auto& numbers = *static_cast<const std::vector<double>*>(*arg);
  if (!pb_encode_tag(stream, PB_WT_STRING, field->tag) ||
      !pb_encode_varint(stream, std::uint64_t{numbers.size()} * sizeof(double))) {
    return false;
  }
  return std::all_of(numbers.begin(), numbers.end(),
                     [&](const double& number) { return pb_encode_fixed64(stream, &number); });
}

// What the next two allocate is bounded by the bytes that are left, which nanopb has checked against the buffer.

bool decode_text(pb_istream_t* stream, Field, void** arg) {
  auto& text = *static_cast<std::string*>(*arg);
  text.resize(stream->bytes_left);
  return pb_read(stream, reinterpret_cast<pb_byte_t*>(text.data()), text.size());
}

bool decode_numbers(pb_istream_t* stream, Field, void** arg) {
  auto& numbers = *static_cast<std::vector<double>*>(*arg);
  numbers.resize(stream->bytes_left / sizeof(double));
  return std::all_of(numbers.begin(), numbers.end(),
                     [&](double& number) { return pb_decode_fixed64(stream, &number); });
}

enum class Way { encode, decode };

/// nanopb has one pointer type for both directions.
template <Way way, class Item>
pb_callback_t attach(const Item& item) {
  pb_callback_t callback{};
  constexpr bool is_text = std::is_same_v<Item, std::string>;
  if constexpr (way == Way::encode) {
    callback.funcs.encode = is_text ? encode_text : encode_numbers;
  } else {
    callback.funcs.decode = is_text ? decode_text : decode_numbers;
  }
  callback.arg = const_cast<Item*>(&item);
  return callback;
}

template <Way way>
Message message_of(const Checkpoint& checkpoint, const std::vector<double>& signals) {
  const Remembered& remembered = checkpoint.remembered;
  Message message = spindle_twin_firmware_Checkpoint_init_zero;
  message.network_sha256 = attach<way>(checkpoint.network_sha256);
  message.saved_unix_s = checkpoint.saved_unix_s;
  message.model_time_s = remembered.model_time_s;
  message.tare_m = remembered.tare_m;
  message.signals = attach<way>(signals);
  message.nodes_K = attach<way>(remembered.nodes_K);
  message.uncorrected_K = attach<way>(remembered.uncorrected_K);
  message.layout = attach<way>(remembered.layout);
  message.mean = attach<way>(remembered.estimator.mean);
  message.root = attach<way>(remembered.estimator.root);
  message.sensitivities = attach<way>(remembered.estimator.sensitivities);
  message.lagged = attach<way>(remembered.estimator.lagged);
  message.channels = attach<way>(remembered.estimator.channels);
  message.start = attach<way>(remembered.estimator.start);
  message.sensor_tare_K = attach<way>(remembered.sensor_tare.offset_K);
  message.sensor_tare_deviation_K = attach<way>(remembered.sensor_tare.deviation_K);
  message.sensor_tares = remembered.sensor_tare.count;
  return message;
}

std::string first_line(std::span<const std::uint8_t> payload) {
  const std::string_view bytes(reinterpret_cast<const char*>(payload.data()), payload.size());
  return "spindle-twin checkpoint 1 " + rom::sha256_hex(bytes) + "\n";
}

}  // namespace

std::vector<std::uint8_t> encode_checkpoint(const Checkpoint& checkpoint) {
  const auto& from = checkpoint.remembered.signals;
  const std::vector<double> signals(from.begin(), from.end());
  const Message message = message_of<Way::encode>(checkpoint, signals);
  std::size_t size = 0;
  if (!pb_get_encoded_size(&size, spindle_twin_firmware_Checkpoint_fields, &message)) {
    throw std::logic_error("a checkpoint has no size");
  }
  std::vector<std::uint8_t> payload(size);
  pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
  if (!pb_encode(&stream, spindle_twin_firmware_Checkpoint_fields, &message)) {
    throw std::logic_error("a checkpoint cannot be encoded");
  }
  const std::string line = first_line(payload);
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

Checkpoint decode_checkpoint(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  const auto end_of_line = std::find(bytes.begin(), bytes.end(), std::uint8_t{'\n'});
  const auto begin = end_of_line == bytes.end() ? end_of_line : end_of_line + 1;
  const std::span<const std::uint8_t> payload(begin, bytes.end());
  const std::string expected = first_line(payload);
  if (!std::equal(bytes.begin(), begin, expected.begin(), expected.end())) {
    throw rom::InputError({file, 0}, "", "no checkpoint of this version, or damaged");
  }
  Checkpoint checkpoint;
  std::vector<double> signals;
  Message message = message_of<Way::decode>(checkpoint, signals);
  pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
  const bool read = pb_decode(&stream, spindle_twin_firmware_Checkpoint_fields, &message);
  // Checkpoints of before heats could be measured have no signals of them.
  if (!read || (signals.size() != signal_count && signals.size() != first_heat_signal)) {
    throw rom::InputError({file, 0}, "", "malformed");
  }
  checkpoint.saved_unix_s = message.saved_unix_s;
  checkpoint.remembered.started = true;
  checkpoint.remembered.model_time_s = message.model_time_s;
  checkpoint.remembered.tare_m = message.tare_m;
  checkpoint.remembered.sensor_tare.count = message.sensor_tares;
  std::copy(signals.begin(), signals.end(), checkpoint.remembered.signals.begin());
  return checkpoint;
}

void write_checkpoint(const Checkpoint& checkpoint, const std::string& path) {
  rom::write_whole_file(path, encode_checkpoint(checkpoint));
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) return std::nullopt;
  return decode_checkpoint(rom::read_whole_file(path, largest_checkpoint_bytes), path);
}

}  // namespace spindle_twin::firmware
