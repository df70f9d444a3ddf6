#include "firmware/keep/checkpoint.hpp"

#include <algorithm>
#include <span>

#include "firmware/keep/checkpoint.pb.h"
#include "firmware/keep/state_files.hpp"
#include "rom/file/packed_message.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::attach;
using rom::Way;

using Message = spindle_twin_firmware_Checkpoint;
template <Way way>
Message message_of(const Checkpoint& checkpoint, const std::vector<double>& signals) {
  const Remembered& remembered = checkpoint.remembered;
  Message message = spindle_twin_firmware_Checkpoint_init_zero;
  message.network_sha256 = attach<way>(checkpoint.network_sha256);
  message.saved_unix_s = checkpoint.saved_unix_s;
  message.model_time_s = remembered.model_time_s;
  message.tare_m = remembered.tare_m;
  message.trial_away_m = remembered.trial_away_m;
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
  message.scale = attach<way>(remembered.estimator.scale);
  message.determined = remembered.estimator.determined;
  message.calibration_contradicted = !remembered.estimator.knows_calibration;
  message.spindle = attach<way>(remembered.spindle);
  message.calibration = attach<way>(remembered.calibration);
  message.unknowns = attach<way>(remembered.unknowns);
  message.nominal = attach<way>(remembered.estimator.nominal);
  message.sensor_tare_K = attach<way>(remembered.sensor_tare.offset_K);
  message.sensor_tare_deviation_K = attach<way>(remembered.sensor_tare.deviation_K);
  message.sensor_health = attach<way>(remembered.sensor_health);
  message.sensor_course = attach<way>(remembered.sensor_course);
  message.sensor_tares = remembered.sensor_tare.count;
  message.order_revision = checkpoint.order_revision;
  message.boot = attach<way>(checkpoint.saved.boot);
  message.saved_boot_s = checkpoint.saved.s;
  return message;
}

constexpr const char* format = "checkpoint 1";

}  // namespace

std::vector<std::uint8_t> encode_checkpoint(const Checkpoint& checkpoint) {
  const auto& from = checkpoint.remembered.signals;
  const std::vector<double> signals(from.begin(), from.end());
  const Message message = message_of<Way::encode>(checkpoint, signals);
  return rom::seal(format, spindle_twin_firmware_Checkpoint_fields, &message);
}

Checkpoint decode_checkpoint(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  const std::span<const std::uint8_t> payload = rom::unseal(format, bytes, file);
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
  checkpoint.order_revision = message.order_revision;
  checkpoint.saved.s = message.saved_boot_s;
  checkpoint.remembered.started = true;
  checkpoint.remembered.model_time_s = message.model_time_s;
  checkpoint.remembered.tare_m = message.tare_m;
  checkpoint.remembered.estimator.knows_calibration = !message.calibration_contradicted;
  checkpoint.remembered.estimator.determined = message.determined;
  checkpoint.remembered.trial_away_m = message.trial_away_m;
  checkpoint.remembered.sensor_tare.count = message.sensor_tares;
  std::copy(signals.begin(), signals.end(), checkpoint.remembered.signals.begin());
  return checkpoint;
}

void write_checkpoint(const Checkpoint& checkpoint, const std::string& path) {
  rom::write_whole_file(path, encode_checkpoint(checkpoint));
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  if (!exists_as_file(path)) return std::nullopt;
  return decode_checkpoint(rom::read_whole_file(path, largest_checkpoint_bytes), path);
}

}  // namespace spindle_twin::firmware
