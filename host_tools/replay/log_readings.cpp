#include "host_tools/replay/log_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace spindle_twin::host_tools {
namespace {

/// Empty where it never changes.
std::optional<double> own_resolution_K(const Log& log, std::size_t sensor) {
  constexpr double longest_hold_s = 10.0, usual_share = 0.9, finest_K = 0.01;
  double step_K = coarsest_resolution_K;
  std::vector<double> held_s;
  const LogRow* since = nullptr;
  for (const LogRow& row : log.rows) {
    const double reading_K = row.measured_K[sensor];
    if (!std::isfinite(reading_K) || (since && reading_K == since->measured_K[sensor])) continue;
    if (since) {
      held_s.push_back(row.time_s - since->time_s);
      step_K = std::min(step_K, std::abs(reading_K - since->measured_K[sensor]));
    }
    since = &row;
  }
  if (held_s.empty()) return {};
  const auto usual = held_s.begin() + static_cast<std::ptrdiff_t>(usual_share * static_cast<double>(held_s.size() - 1));
  std::nth_element(held_s.begin(), usual, held_s.end());
  return *usual <= longest_hold_s ? std::max(step_K, finest_K) : coarsest_resolution_K;
}

}  // namespace

double resolution_of_log_K(const Log& log, std::size_t sensor) {
  if (const auto own_K = own_resolution_K(log, sensor)) return *own_K;
  double others_K = coarsest_resolution_K;
  for (std::size_t k = 0; k < log.has_sensor.size(); ++k) {
    if (log.has_sensor[k]) others_K = std::min(others_K, own_resolution_K(log, k).value_or(coarsest_resolution_K));
  }
  return others_K;
}

std::optional<double> start_of_log_K(const Log& log) {
  constexpr double start_lasts_s = 60.0;
  std::array<bool, firmware::slots::key_points> has_read{};
  double first_s = 0.0, sum_K = 0.0;
  int count = 0;
  for (const LogRow& row : log.rows) {
    if (count > 0 && row.time_s > first_s + start_lasts_s) break;
    for (std::size_t k = 0; k < has_read.size(); ++k) {
      if (!log.has_sensor[k] || has_read[k] || row.disbelieved[k] || !std::isfinite(row.measured_K[k])) continue;
      if (count == 0) first_s = row.time_s;
      has_read[k] = true;
      sum_K += row.measured_K[k];
      ++count;
    }
  }
  return count > 0 ? std::optional(sum_K / count) : std::nullopt;
}

double noise_of_log_K(const Log& log, std::size_t sensor) {
  constexpr double deviations_per_median = 1.4826;  // of a normal distribution
  std::vector<double> bends_K;
  double before_K = 0.0, last_K = 0.0;
  int readings = 0;
  for (const LogRow& row : log.rows) {
    const double reading_K = row.measured_K[sensor];
    if (!std::isfinite(reading_K)) continue;
    if (++readings > 2) bends_K.push_back(std::abs(before_K - 2.0 * last_K + reading_K));
    before_K = last_K;
    last_K = reading_K;
  }
  if (bends_K.empty()) return 0.0;
  const auto middle = bends_K.begin() + static_cast<std::ptrdiff_t>(bends_K.size() / 2);
  std::nth_element(bends_K.begin(), middle, bends_K.end());
  return deviations_per_median * *middle / std::sqrt(6.0);
}

}  // namespace spindle_twin::host_tools
