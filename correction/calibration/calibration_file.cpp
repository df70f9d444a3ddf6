#include <algorithm>
#include <cmath>
#include <span>
#include <sstream>
#include <string_view>

#include "correction/calibration/calibration.hpp"
#include "correction/calibration/calibration.pb.h"
#include "rom/file/packed_message.hpp"
#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

using CalibrationMessage = spindle_twin_correction_Calibration;

constexpr const char* calibration_format = "calibration 1";
constexpr const char* signed_format = "calibration 1 signed";
constexpr std::string_view calibration_purpose = "spindle-twin calibration\n";
constexpr std::uint64_t largest_calibration_bytes = 1 << 22;
constexpr std::size_t most_parameters = 512;

/// The fields that nanopb hands over by callback.
struct CalibrationLists {
  std::string spindle, network_sha256, names, logs;
  std::vector<double> mean, root, prior_mean, prior_deviation, nominal;
};

template <rom::Way way>
CalibrationMessage calibration_message(const CalibrationLists& lists) {
  CalibrationMessage message = spindle_twin_correction_Calibration_init_zero;
  message.spindle = rom::attach<way>(lists.spindle);
  message.network_sha256 = rom::attach<way>(lists.network_sha256);
  message.names = rom::attach<way>(lists.names);
  message.logs = rom::attach<way>(lists.logs);
  message.mean = rom::attach<way>(lists.mean);
  message.root = rom::attach<way>(lists.root);
  message.prior_mean = rom::attach<way>(lists.prior_mean);
  message.prior_deviation = rom::attach<way>(lists.prior_deviation);
  message.nominal = rom::attach<way>(lists.nominal);
  return message;
}

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<double> numbers_of(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

Eigen::VectorXd vector_of(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

bool all_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double each) { return std::isfinite(each); });
}

}  // namespace

std::vector<std::uint8_t> encode_calibration(const Calibration& calibration, const rom::PrivateKey* key) {
  CalibrationLists lists{calibration.spindle,
                         calibration.network_sha256,
                         joined_lines(calibration.names),
                         joined_lines(calibration.logs),
                         numbers_of(calibration.mean),
                         {},
                         numbers_of(calibration.prior_mean),
                         numbers_of(calibration.prior_deviation),
                         numbers_of(calibration.nominal)};
  const Eigen::Index n = calibration.mean.size();
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) lists.root.push_back(calibration.root(i, j));
  }
  CalibrationMessage message = calibration_message<rom::Way::encode>(lists);
  message.made_unix_s = calibration.made_unix_s;
  message.tested_s = calibration.tested_s;
  message.promised_m = calibration.promised_m;
  message.accepted = calibration.accepted;
  std::vector<std::uint8_t> bytes = rom::seal(key != nullptr ? signed_format : calibration_format,
                                              spindle_twin_correction_Calibration_fields, &message);
  if (key == nullptr) return bytes;
  const std::vector<std::uint8_t> block = rom::signature_block(calibration_purpose, bytes, *key);
  bytes.insert(bytes.end(), block.begin(), block.end());
  return bytes;
}

namespace {

bool says_signed(std::span<const std::uint8_t> bytes) {
  const std::string begin = std::string("spindle-twin ") + signed_format + " ";
  return bytes.size() >= begin.size() && std::equal(begin.begin(), begin.end(), bytes.begin());
}

Calibration decode_message(std::span<const std::uint8_t> payload, const std::string& file) {
  CalibrationLists lists;
  CalibrationMessage message = calibration_message<rom::Way::decode>(lists);
  pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
  const bool read = pb_decode(&stream, spindle_twin_correction_Calibration_fields, &message);
  Calibration calibration;
  calibration.names = split_lines(lists.names);
  calibration.logs = split_lines(lists.logs);
  const std::size_t n = calibration.names.size();
  const bool sized = read && n >= 1 && n <= most_parameters && lists.mean.size() == n &&
                     lists.root.size() == n * (n + 1) / 2 && lists.prior_mean.size() == n &&
                     lists.prior_deviation.size() == n && (lists.nominal.empty() || lists.nominal.size() == n);
  if (!sized || !all_finite(lists.mean) || !all_finite(lists.root) || !all_finite(lists.prior_mean) ||
      !all_finite(lists.prior_deviation) || !all_finite(lists.nominal) ||
      !all_finite({message.made_unix_s, message.tested_s, message.promised_m})) {
    throw rom::InputError({file, 0}, "", "malformed");
  }
  calibration.spindle = lists.spindle;
  calibration.network_sha256 = lists.network_sha256;
  calibration.made_unix_s = message.made_unix_s;
  calibration.tested_s = message.tested_s;
  calibration.promised_m = message.promised_m;
  calibration.accepted = message.accepted;
  calibration.mean = vector_of(lists.mean);
  calibration.prior_mean = vector_of(lists.prior_mean);
  calibration.prior_deviation = vector_of(lists.prior_deviation);
  calibration.nominal = vector_of(lists.nominal);
  const auto size = static_cast<Eigen::Index>(n);
  calibration.root = Eigen::MatrixXd::Zero(size, size);
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index i = j; i < size; ++i) calibration.root(i, j) = lists.root[next++];
    if (!(calibration.root(j, j) > 0.0)) throw rom::InputError({file, 0}, "root", "its diagonal must be above 0");
  }
  return calibration;
}

}  // namespace

CalibrationFile decode_calibration(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  CalibrationFile result;
  if (!says_signed(bytes)) {
    result.calibration = decode_message(rom::unseal(calibration_format, bytes, file), file);
    return result;
  }
  const std::size_t behind = std::min(rom::signature_block_size, bytes.size());
  const auto sealed = std::span(bytes).first(bytes.size() - behind);
  const std::span<const std::uint8_t> payload = rom::unseal(signed_format, sealed, file);
  result.signed_by = rom::signer_of(calibration_purpose, sealed, std::span(bytes).last(behind));
  if (!result.signed_by) throw rom::InputError({file, 0}, "signature", "does not fit the file, or is damaged");
  result.calibration = decode_message(payload, file);
  return result;
}

void write_calibration(const Calibration& calibration, const std::string& path, const rom::PrivateKey* key) {
  rom::write_whole_file(path, encode_calibration(calibration, key));
}

CalibrationFile read_calibration_file(const std::string& path) {
  return decode_calibration(rom::read_whole_file(path, largest_calibration_bytes), path);
}

Calibration read_calibration(const std::string& path) { return read_calibration_file(path).calibration; }

}  // namespace spindle_twin::correction
