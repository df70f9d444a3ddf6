#pragma once

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// The course that a channel had before a gap in its readings, for those behind it to be held against. What came
/// between two gaps, or the start and a gap, counts only where it lasted return_after_s: plugs are tried. All functions
/// may run in the cycle.
class CourseOverGap {
 public:
  /// A channel in use is on its course, at time_s; e of course_tracker.hpp.
  void note_course(double detrended_K, double time_s) {
    last_K_ = detrended_K;
    last_s_ = time_s;
  }
  /// A right reading at time_s, which is or is not the first behind a gap.
  void note_reading(double time_s, bool was_away, const HealthLimits& limits) {
    if (readings_ == 0) returned_s_ = time_s;
    if (!was_away) {
      ++readings_;
      return;
    }
    if (last_s_ - returned_s_ >= limits.return_after_s) {
      before_K_ = last_K_;
      before_s_ = last_s_;
    }
    returned_s_ = time_s;
    readings_ = 1;
  }

  /// The gap is one of the daemon: the course before it was this, and `age_s` ago at time_s.
  void resume(double before_K, double time_s, double age_s) {
    before_K_ = before_K;
    before_s_ = time_s - age_s;
  }

  /// The last reading is the first one behind a gap, or the first of all.
  bool is_first() const { return readings_ <= 1; }
  /// The last reading is one of the limits.outliers first ones behind a gap.
  bool has_just_ended(const HealthLimits& limits) const { return readings_ <= limits.outliers; }
  /// The course before the gap is known, and no older than replug_s.
  bool is_known(double time_s, const HealthLimits& limits) const { return time_s - before_s_ <= limits.replug_s; }
  double before_K() const { return before_K_; }
  /// Since the channel was on its course last; beyond all bounds where it never was.
  double age_s(double time_s) const { return time_s - last_s_; }

 private:
  static constexpr double never_s = -1e18;
  double last_K_ = 0.0, last_s_ = never_s;
  double before_K_ = 0.0, before_s_ = never_s;
  double returned_s_ = never_s;
  int readings_ = 0;
};

}  // namespace spindle_twin::correction
