#pragma once

#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// What outliers in a row mean: a jump stays where it went; what goes on in the same direction by more than half of the
/// first step is the place, which warms faster than the model. All functions may run in the cycle.
class JumpDetector {
 public:
  enum class Meaning {
    open,        ///< too few yet
    jump,        ///< the channel has jumped
    place_moves  ///< the place has: the course is to begin anew here
  };

  /// One more outlier, by its detrended reading and what the course had expected instead.
  Meaning note_outlier(double detrended_K, double expected_K, const HealthLimits& limits) {
    if (in_a_row_ == 0) {
      first_K_ = detrended_K;
      first_miss_K_ = detrended_K - expected_K;
    }
    since_K_ = detrended_K - first_K_;
    if (++in_a_row_ < limits.outliers) return Meaning::open;
    const bool goes_on = since_K_ * first_miss_K_ > 0.0 && std::abs(since_K_) > 0.5 * std::abs(first_miss_K_);
    return goes_on ? Meaning::place_moves : Meaning::jump;
  }
  /// The row of outliers is over. True where there was one: a spike.
  bool end_row() {
    const bool was_off = in_a_row_ > 0;
    in_a_row_ = 0;
    return was_off;
  }
  int in_a_row() const { return in_a_row_; }
  double since_first_K() const { return since_K_; }  ///< what the last outlier is above the first of its row

 private:
  int in_a_row_ = 0;
  double first_K_ = 0.0;
  double first_miss_K_ = 0.0;
  double since_K_ = 0.0;
};

}  // namespace spindle_twin::correction
