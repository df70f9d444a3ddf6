#pragma once

#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Whether the misfit that a channel was failed for has gone, now that the estimate does without it. A healthy sensor
/// that was blamed for what the model was wrong by soon fits what the others say; one that drifts never does. With m
/// the running mean over a minute of reading − offset − prediction, m₀ and σ those of the verdict:
///   gone     |m| <= min(review_deviations σ, review_share |m₀|)
/// All functions may run in the cycle.
class MisfitReview {
 public:
  /// The channel was failed at time_s for a misfit with its 1σ > 0. While the model was in doubt the review stays open;
  /// else it is over after review_s. [K]
  void begin(double time_s, double misfit_K, double deviation_K, bool model_in_doubt) {
    active_ = true;
    endless_ = model_in_doubt;
    begin_s_ = time_s;
    mean_K_ = first_K_ = misfit_K;
    deviation_K_ = deviation_K;
  }
  /// Nobody asks any more: the channel was acknowledged, or failed for another reason.
  void dismiss() { active_ = false; }

  /// One reading of the failed channel against the prediction of all others, h_s after the one before. [K]
  void note(double misfit_K, double h_s) { mean_K_ += (1.0 - std::exp(-h_s / memory_s)) * (misfit_K - mean_K_); }

  bool is_active() const { return active_; }
  /// Whether the verdict holds for good, unless the review takes it back.
  bool will_latch() const { return active_ && !endless_; }
  bool is_over(double time_s, const HealthLimits& limits) const {
    return will_latch() && time_s - begin_s_ > limits.review_s;
  }
  bool has_gone(const HealthLimits& limits) const {
    return std::abs(mean_K_) <= limits.review_deviations * deviation_K_ &&
           std::abs(mean_K_) <= limits.review_share * std::abs(first_K_);
  }

 private:
  static constexpr double memory_s = 60.0;  ///< six updates: one that jumps does not decide
  bool active_ = false;
  bool endless_ = false;
  double begin_s_ = 0.0;
  double first_K_ = 0.0;
  double mean_K_ = 0.0;
  double deviation_K_ = 0.0;
};

}  // namespace spindle_twin::correction
