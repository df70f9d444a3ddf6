#pragma once

#include <cmath>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// A known value in the compensation's place, with which a person tries the control's input. It ends by an order, when
/// who gave it does not say within a minute to be there still, and ten minutes after the value was given in any case.
/// Times of the clock, not of the model: a person waits. All functions may run in the cycle.
class CompensationTrial {
 public:
  static constexpr double renewed_within_s = 60.0;
  static constexpr double longest_s = 600.0;

  void begin(double value_m, double now_s) {
    value_m_ = value_m;
    begun_s_ = renewed_s_ = now_s;
  }
  /// Does not begin one that has ended.
  void renew(double now_s) { renewed_s_ = now_s; }
  void end() { value_m_ = not_a_value; }

  /// Ends it where its time is over. The value in m; NaN: there is none.
  double value_m(double now_s) {
    if (!(left_s(now_s) > 0.0)) end();
    return value_m_;
  }
  /// Until it ends by itself; NaN without one.
  double left_s(double now_s) const {
    if (std::isnan(value_m_)) return not_a_value;
    return std::fmin(renewed_s_ + renewed_within_s, begun_s_ + longest_s) - now_s;
  }

 private:
  double value_m_ = not_a_value;
  double begun_s_ = 0.0;
  double renewed_s_ = 0.0;
};

}  // namespace spindle_twin::firmware
