#pragma once

#include <cmath>
#include <limits>

namespace spindle_twin::correction {

/// Running mean of reading − prediction while a channel was good, over two minutes: the course it must come back to
/// after a fault. All functions may run in the cycle.
class UsualOffset {
 public:
  /// One reading of a good channel, h_s after the one before. [K]
  void learn(double offset_K, double h_s) {
    const double weight = known_ ? 1.0 - std::exp(-h_s / memory_s) : 1.0;
    mean_K_ += weight * (offset_K - mean_K_);
    known_ = true;
  }
  /// How far a reading is off that course; 0 where none is known. [K]
  double departure_K(double offset_K) const { return known_ ? offset_K - mean_K_ : 0.0; }
  /// NaN where none is known. [K]
  double mean_K() const { return known_ ? mean_K_ : std::numeric_limits<double>::quiet_NaN(); }
  /// The channel came back: what it was before does not count any more.
  void forget() {
    known_ = false;
    mean_K_ = 0.0;
  }

 private:
  static constexpr double memory_s = 120.0;  ///< twelve updates of the estimator, which the prediction jumps with
  double mean_K_ = 0.0;
  bool known_ = false;
};

}  // namespace spindle_twin::correction
