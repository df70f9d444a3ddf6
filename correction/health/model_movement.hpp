#pragma once

#include <cmath>

namespace spindle_twin::correction {

/// What the model of a place has moved since the start, in the two forms the detectors need. In a steady state with a
/// heat that is wrong for good, integration moves the model and corrections take it back, over and over; the detrended
/// reading then runs away at the opposite rate. That rate is learnt over ten minutes and left out of the second form.
/// All functions may run in the cycle.
class ModelMovement {
 public:
  /// The model moved by moved_K in h_s >= 0, by integration alone.
  void add(double moved_K, double h_s) {
    integrated_K_ += moved_K;
    steady_K_ += moved_K + rate_K_per_s_ * h_s;
  }
  /// Learns at which rate the detrended reading runs away, h_s after the one before.
  void learn(double detrended_K, double h_s) {
    if (has_last_ && h_s > 0.0) {
      const double rate_K_per_s = (detrended_K - last_detrended_K_) / h_s;
      rate_K_per_s_ += (1.0 - std::exp(-h_s / memory_s)) * (rate_K_per_s - rate_K_per_s_);
    }
    last_detrended_K_ = detrended_K;
    has_last_ = true;
  }
  /// The next reading is no neighbour of the last one: nothing is learnt from their difference.
  void interrupt() { has_last_ = false; }

  double integrated_K() const { return integrated_K_; }  ///< u
  double steady_K() const { return steady_K_; }          ///< u without what corrections keep taking back

 private:
  static constexpr double memory_s = 600.0;  ///< sixty updates, ten times what a heat needs to be corrected
  double integrated_K_ = 0.0;
  double steady_K_ = 0.0;
  double rate_K_per_s_ = 0.0;
  double last_detrended_K_ = 0.0;
  bool has_last_ = false;
};

}  // namespace spindle_twin::correction
