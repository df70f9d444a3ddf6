#pragma once

#include <array>
#include <string>
#include <vector>

#include "host_tools/replay/replay.hpp"

namespace spindle_twin::host_tools {

/// Prediction minus measurement of one output, in SI.
struct ErrorStatistics {
  std::size_t count = 0;
  double sum_of_squares = 0.0;
  double worst = 0.0;  ///< with its sign
  double worst_at_s = 0.0;
  double last = 0.0;

  void add(double error, double time_s);
  double rms() const;
};

struct OutputErrors {
  std::string name;
  bool used = false;     ///< by the correction; the others only judge
  double lowest = 0.0;   ///< measured
  double highest = 0.0;  ///< measured
  ErrorStatistics twin{};
  ErrorStatistics uncorrected{};  ///< without a count where the cycle does not publish it

  // Against the published standard deviation, where there is one; the reading's own noise is not in it.
  std::size_t with_deviation = 0;
  std::size_t within_2_deviations = 0;
  double sum_of_variances = 0.0;

  double deviation() const;  ///< root mean square
  double rise() const { return highest - lowest; }
};

/// Compares readings with what was predicted for their instants before they were known; between two predictions linear
/// in time. A reading outside its sensor's limits is a fault of the sensor and counts nowhere.
class ReplayErrors {
 public:
  /// Nothing before from_s counts.
  ReplayErrors(const rom::Network& network, const firmware::CyclePlan& plan, const Log& log, double from_s);

  /// Every reading up to this cycle's instant; returns predicted minus measured per key point, NaN without a reading.
  const std::vector<double>& add(const ReplayedCycle& cycle);

  /// Those that the log has.
  const std::vector<OutputErrors>& sensors() const { return sensors_; }
  const std::vector<OutputErrors>& deformations() const { return deformations_; }

 private:
  struct Prediction {
    double time_s = 0.0;
    firmware::Snapshot snapshot;
  };
  void judge(const LogRow& row);

  const Log& log_;
  std::array<firmware::SensorPlan, firmware::slots::key_points> limits_;
  double from_s_;
  double slack_s_;        ///< instants closer than this are the same
  std::size_t next_ = 0;  ///< row
  Prediction before_, after_;
  std::vector<std::size_t> sensor_slots_, deformation_slots_;
  std::vector<OutputErrors> sensors_, deformations_;
  std::vector<double> error_K_;
};

}  // namespace spindle_twin::host_tools
