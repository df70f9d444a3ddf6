#pragma once

#include <cstdint>
#include <optional>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

struct FilterPlan {
  enum class Kind { none, mean, low_pass };
  Kind kind = Kind::none;
  double time_s = 0.0;  ///< clock time: the mean's window, the low pass' time constant
};

/// Brings a channel's samples down to the rate at which anything thermal moves; for a device's own thread.
/// Mean: one reading per window, of the middle of its samples' times; a box has no overshoot and loses no energy, so
/// that a heat's mean stays a heat's mean. Low pass: y += (1 - exp(-dt / time_s)) (x - y) at each sample, whatever
/// their distance; its reading counts as time_s old, which is how far it lags behind a ramp. A sample that is not a
/// number is left out of a mean, which is none only where all are, and ends a low pass.
class ChannelFilter {
 public:
  explicit ChannelFilter(FilterPlan plan) : plan_(plan) {}

  /// Empty: no reading is ready. Times rise.
  std::optional<Reading> take(const Reading& sample);
  /// Forgets all samples.
  void clear() { samples_ = numbers_ = 0; }

 private:
  std::optional<Reading> take_mean(const Reading& sample);
  Reading take_low_pass(const Reading& sample);

  FilterPlan plan_;
  std::int64_t start_ns_ = 0;  ///< of the window; of the low pass: its last sample
  std::int64_t samples_ = 0;
  std::int64_t numbers_ = 0;  ///< samples that are numbers
  double sum_ = 0.0;          ///< of the low pass: its value
  double after_start_ns_ = 0.0;
};

}  // namespace spindle_twin::firmware
