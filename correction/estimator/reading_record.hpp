#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::correction {

/// A touch-off or a reading of a displacement probe.
struct RecordedLength {
  int index = -1;  ///< of the deformation output; -1: none
  double value_m = 0.0;
  double deviation_m = 1.0;
};

/// A stretch of time with held inputs, and what was read in it.
struct RecordedReadings {
  double begin_s = 0.0, end_s = 0.0;
  rom::OperatingState operating;  ///< as read, from begin_s on
  Eigen::VectorXd reading_K;      ///< per sensor, the mean of its readings; NaN without one
  RecordedLength length;          ///< for the update at end_s
};

/// What an estimator was given since some instant, in stretches of two seconds at the most, each with one mean reading
/// per sensor. May run in the cycle but for the constructor.
class ReadingRecord {
 public:
  /// Allocates for `capacity` stretches.
  ReadingRecord(const rom::Boundaries& boundaries, Eigen::Index sensors, std::size_t capacity);

  /// Empty, from time_s on.
  void begin(double time_s, const rom::OperatingState& operating);
  void note_displacement(const RecordedLength& length) { open_.length = length; }
  /// Readings at time_s, not before the last. The stretch ends there if it is long enough, the inputs are others or
  /// `end` says so. False: there is no room any more, and nothing is recorded.
  bool note(double time_s, const Eigen::VectorXd& reading_K, const Eigen::Array<bool, Eigen::Dynamic, 1>& valid,
            const rom::OperatingState& operating, bool end);

  std::size_t count() const { return count_; }
  const RecordedReadings& at(std::size_t i) const { return entries_[i]; }
  double begin_s() const { return begin_s_; }

 private:
  std::vector<RecordedReadings> entries_;
  std::size_t count_ = 0;
  RecordedReadings open_;
  Eigen::VectorXd sums_K_, samples_;
  double begin_s_ = 0.0;
};

}  // namespace spindle_twin::correction
