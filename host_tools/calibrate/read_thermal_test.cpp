#include "host_tools/calibrate/read_thermal_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/growth/growth_reading.hpp"
#include "host_tools/replay/log_readings.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t least_rows = 3;

bool is_new(const Log& log, double age_s) {
  constexpr double of_a_cycle = 1.001;
  return !log.cycle_s || std::isnan(age_s) || age_s < of_a_cycle * *log.cycle_s;
}

bool is_reading(const LogRow& row, std::size_t sensor) {
  return std::isfinite(row.measured_K[sensor]) && !row.disbelieved[sensor];
}

/// The lengths of a log, rows x deformation outputs.
Eigen::MatrixXd lengths_of(const rom::Network& network, const Log& log) {
  const auto rows = static_cast<Eigen::Index>(log.rows.size());
  const auto outputs = static_cast<Eigen::Index>(network.deformations.size());
  Eigen::MatrixXd lengths = Eigen::MatrixXd::Constant(rows, outputs, unknown);
  for (Eigen::Index d = 0; d < outputs; ++d) {
    const auto output = static_cast<std::size_t>(d);
    bool probed = false;
    for (Eigen::Index r = 0; r < rows; ++r) {
      const LogRow& row = log.rows[static_cast<std::size_t>(r)];
      if (log.has_deformation[output]) {
        lengths(r, d) = row.deformation_m[output];
      } else if (log.cycle_s && std::isfinite(row.probe_m[output]) && is_new(log, row.probe_age_s[output])) {
        lengths(r, d) = row.probe_m[output];
      }
      probed = probed || std::isfinite(lengths(r, d));
    }
    for (Eigen::Index r = 1; r < rows && !probed && log.cycle_s; ++r) {
      const LogRow& row = log.rows[static_cast<std::size_t>(r)];
      const bool touched = row.length_orders > log.rows[static_cast<std::size_t>(r - 1)].length_orders &&
                           row.tare_orders == log.rows.back().tare_orders;
      const bool taken = correction::is_growth(row.length.value_m, row.length.deviation_m);
      if (touched && taken && row.length.output == output) lengths(r, d) = row.length.value_m;
    }
  }
  return lengths;
}

}  // namespace

correction::ThermalTest read_thermal_test(const rom::Network& network, const Log& log,
                                          std::optional<double> start_degC) {
  if (log.rows.size() < least_rows) throw rom::InputError({log.file, 0}, "", "must have at least 3 rows");
  correction::ThermalTest test;
  test.name = log.file;
  const auto rows = static_cast<Eigen::Index>(log.rows.size());
  const auto sensors = static_cast<Eigen::Index>(network.key_points.size());
  test.measured_K = Eigen::MatrixXd::Constant(rows, sensors, unknown);
  rom::OperatingState operating = network.boundaries.operating;
  for (Eigen::Index r = 0; r < rows; ++r) {
    const LogRow& row = log.rows[static_cast<std::size_t>(r)];
    take_signals(network, log, row, operating);
    test.time_s.push_back(row.time_s);
    test.operating.push_back(operating);
    for (Eigen::Index k = 0; k < sensors; ++k) {
      const auto sensor = static_cast<std::size_t>(k);
      if (!log.has_sensor[sensor] || !is_reading(row, sensor) || !is_new(log, row.age_s[sensor])) continue;
      test.measured_K(r, k) = row.measured_K[sensor];
    }
  }
  test.deformation_m = lengths_of(network, log);
  const std::optional<double> mean_K = start_of_log_K(log);
  if (!mean_K) {
    throw rom::InputError({log.file, 1}, "measured.<key point>_degC",
                          "a calibration needs readings of at least one key point");
  }
  test.start_K = start_degC ? *start_degC + firmware::zero_degC_K : *mean_K;
  return test;
}

std::vector<int> readings_left_out(const rom::Network& network, const Log& log) {
  std::vector<int> count(network.key_points.size(), 0);
  for (const LogRow& row : log.rows) {
    for (std::size_t k = 0; k < count.size(); ++k) {
      const bool is_new_one = std::isfinite(row.measured_K[k]) && is_new(log, row.age_s[k]);
      if (is_new_one && row.disbelieved[k]) ++count[k];
    }
  }
  return count;
}

}  // namespace spindle_twin::host_tools
