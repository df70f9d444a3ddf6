#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Alpha-beta tracker of a reading against its own last values, freed from what the model says the temperature has
/// done. With r the reading and u what the model has moved by integration alone (its corrections left out, which move
/// without any reason in the sensor), the detrended reading e = r − u is slow. It is followed by a tracker of constant
/// gains (Kalata, IEEE Trans. AES 20, 1984):
///   ê = c + ċ h,   d = e − ê,   c = ê + α d,   ċ += β d / h
/// An outlier is |d| > max(jump, 6 s, 2.5 q) + share · (Σ |Δu| of the last four samples), s the mean deviation of d
/// from the accepted samples, q the step of the reading. The share is for speed steps, where the model's heat is wrong
/// by as much; a model that relaxes from a wrong start bends e all the same, so that a channel asks the reading itself
/// besides (Channel::stepped_K). Outliers leave the course alone. All functions may run in the cycle.
class CourseTracker {
 public:
  /// Forgets the course: the next samples are judged by nothing until three were accepted.
  void restart() { samples_ = 0; }

  /// Carries the course on by h_s >= 0, in which the model moved by model_moved_K; once per sample, before the others.
  void carry_on(double model_moved_K, double h_s, double resolution_K, const HealthLimits& limits) {
    moved_K_[static_cast<std::size_t>(at_)] = std::abs(model_moved_K);
    at_ = (at_ + 1) % static_cast<int>(moved_K_.size());
    course_K_ += slope_K_per_s_ * h_s;
    expected_K_ = course_K_;
    double moved_sum_K = 0.0;
    for (const double moved_K : moved_K_) moved_sum_K += moved_K;
    limit_K_ = least_jump_K(resolution_K, limits) + limits.jump_share * moved_sum_K;
  }

  /// Whether the detrended reading is off its course. Never before the course is known.
  bool is_outlier(double detrended_K) const {
    return samples_ >= settled && std::abs(detrended_K - expected_K_) > limit_K_;
  }

  /// Begins a new course with this reading, which changes at this rate as far as is known.
  void begin(double detrended_K, double rate_K_per_s, double stated_noise_K) {
    samples_ = 0;
    accept(detrended_K, 0.0, stated_noise_K);
    slope_K_per_s_ = rate_K_per_s;
  }

  /// Takes a detrended reading into the course, h_s after the one before. The noise learnt stays between 1/3 and 3
  /// times the stated one, 1σ > 0.
  void accept(double detrended_K, double h_s, double stated_noise_K) {
    if (samples_ == 0) {
      course_K_ = expected_K_ = detrended_K;
      slope_K_per_s_ = 0.0;
      noise_K_ = stated_noise_K;
    }
    const double off_K = detrended_K - expected_K_;
    course_K_ = expected_K_ + alpha * off_K;
    if (h_s > 0.0) slope_K_per_s_ += beta * off_K / h_s;
    noise_K_ += noise_memory * (rms_per_mean * std::abs(off_K) - noise_K_);
    noise_K_ = noise_K(stated_noise_K);
    ++samples_;
  }

  /// 1σ of a reading as learnt, between 1/3 and 3 times the stated one.
  double noise_K(double stated_noise_K) const {
    return std::clamp(noise_K_, stated_noise_K / 3.0, 3.0 * stated_noise_K);
  }
  /// What makes an outlier of a place that does not move, at least: max(jump, 6 s, 2.5 steps of the reading).
  double least_jump_K(double resolution_K, const HealthLimits& limits) const {
    return std::max({limits.jump_K, deviations * noise_K_, steps * resolution_K});
  }
  double expected_K() const { return expected_K_; }  ///< ê of this sample
  double limit_K() const { return limit_K_; }        ///< beyond which |d| is an outlier

 private:
  // Critically damped to the eye: β = α² / (2 − α) (Benedict and Bordner, IRE Trans. AC 7, 1962). Follows a ramp within
  // some ten samples, and lets a third of the noise through.
  static constexpr double alpha = 0.3;
  static constexpr double beta = 0.05;
  static constexpr double noise_memory = 0.02;    ///< share of a new sample in s: fifty samples
  static constexpr double steps = 2.5;            ///< a reading flickers by one, and noise by another
  static constexpr double deviations = 6.0;       ///< a normal one goes beyond once in 5e8 samples
  static constexpr int settled = 3;               ///< two for value and slope, one to judge these by
  static constexpr double rms_per_mean = 1.2533;  ///< √(π/2) of a normal distribution

  double course_K_ = 0.0;
  double slope_K_per_s_ = 0.0;
  double noise_K_ = 0.0;
  double expected_K_ = 0.0;
  double limit_K_ = 0.0;
  std::array<double, 4> moved_K_{};
  int at_ = 0;
  int samples_ = 0;
};

}  // namespace spindle_twin::correction
