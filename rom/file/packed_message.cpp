#include "rom/file/packed_message.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::rom {
namespace {

std::string first_line(const std::string& kind, std::span<const std::uint8_t> payload) {
  const std::string_view bytes(reinterpret_cast<const char*>(payload.data()), payload.size());
  return "spindle-twin " + kind + " " + sha256_hex(bytes) + "\n";
}

}  // namespace

bool pack_text(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& text = *static_cast<const std::string*>(*arg);
  return pb_encode_tag_for_field(stream, field) &&
         pb_encode_string(stream, reinterpret_cast<const pb_byte_t*>(text.data()), text.size());
}

bool pack_numbers(pb_ostream_t* stream, const pb_field_t* field, void* const* arg) {
  const auto& numbers = *static_cast<const std::vector<double>*>(*arg);
  if (!pb_encode_tag(stream, PB_WT_STRING, field->tag) ||
      !pb_encode_varint(stream, std::uint64_t{numbers.size()} * sizeof(double))) {
    return false;
  }
  return std::all_of(numbers.begin(), numbers.end(),
                     [&](const double& number) { return pb_encode_fixed64(stream, &number); });
}

// What the next two allocate is bounded by the bytes that are left, which nanopb has checked against the buffer.

bool unpack_text(pb_istream_t* stream, const pb_field_t*, void** arg) {
  auto& text = *static_cast<std::string*>(*arg);
  text.resize(stream->bytes_left);
  return pb_read(stream, reinterpret_cast<pb_byte_t*>(text.data()), text.size());
}

bool unpack_numbers(pb_istream_t* stream, const pb_field_t*, void** arg) {
  auto& numbers = *static_cast<std::vector<double>*>(*arg);
  numbers.resize(stream->bytes_left / sizeof(double));
  return std::all_of(numbers.begin(), numbers.end(),
                     [&](double& number) { return pb_decode_fixed64(stream, &number); });
}

std::vector<std::uint8_t> seal(const std::string& format, const pb_msgdesc_t* fields, const void* message) {
  std::size_t size = 0;
  if (!pb_get_encoded_size(&size, fields, message)) throw std::logic_error("a message has no size");
  std::vector<std::uint8_t> payload(size);
  pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
  if (!pb_encode(&stream, fields, message)) throw std::logic_error("a message cannot be encoded");
  const std::string line = first_line(format, payload);
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

std::span<const std::uint8_t> unseal(const std::string& format, std::span<const std::uint8_t> bytes,
                                     const std::string& file) {
  const auto end_of_line = std::find(bytes.begin(), bytes.end(), std::uint8_t{'\n'});
  const auto begin = end_of_line == bytes.end() ? end_of_line : end_of_line + 1;
  const std::span<const std::uint8_t> payload(begin, bytes.end());
  const std::string expected = first_line(format, payload);
  if (std::equal(bytes.begin(), begin, expected.begin(), expected.end())) return payload;
  throw InputError({file, 0}, "", "no " + format.substr(0, format.find(' ')) + " of this version, or damaged");
}

}  // namespace spindle_twin::rom
