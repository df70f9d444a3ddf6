#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Reading against its own last values, freed from what the model says the temperature has done. With r the reading and
/// u what the model has moved by integration alone (its corrections left out, which move without any reason in the
/// sensor), e = r − u is a slow signal. Its course is followed by an α-β filter (Kalata 1984):
///   ê = c + ċ h,   d = e − ê,   c = ê + α d,   ċ += β d / h
/// An outlier is |d| > max(jump, 6 s) + share · (Σ |Δu| of the last four samples), s the mean deviation of d from the
/// accepted samples. The share is for speed steps, where the model's heat is wrong by as much. Outliers leave the
/// course alone. Runs in the cycle.
struct Course {
  static constexpr double alpha = 0.3;
  static constexpr double beta = 0.05;
  static constexpr double noise_memory = 0.02;  ///< share of a new sample in s
  static constexpr double deviations = 6.0;
  static constexpr int settle = 3;  ///< first samples, which nothing can be judged by

  double course_K = 0.0;
  double slope_K_per_s = 0.0;
  double noise_K = 0.0;
  double expected_K = 0.0;  ///< ê
  double limit_K = 0.0;
  std::array<double, 4> moved_K{};
  int at = 0;
  int samples = 0;

  void restart() { samples = 0; }

  /// Carries the course on by h_s; call once per sample before outlier() and accept().
  void advance(double model_moved_K, double h_s, const HealthLimits& limits) {
    moved_K[static_cast<std::size_t>(at)] = std::abs(model_moved_K);
    at = (at + 1) % static_cast<int>(moved_K.size());
    course_K += slope_K_per_s * h_s;
    expected_K = course_K;
    double moved_sum_K = 0.0;
    for (const double moved : moved_K) moved_sum_K += moved;
    limit_K = std::max(limits.jump_K, deviations * noise_K) + limits.jump_share * moved_sum_K;
  }

  bool outlier(double e_K) const { return samples >= settle && std::abs(e_K - expected_K) > limit_K; }

  void accept(double e_K, double h_s, double stated_noise_K) {
    if (samples == 0) {
      course_K = expected_K = e_K;
      slope_K_per_s = 0.0;
      noise_K = stated_noise_K;
    }
    const double d_K = e_K - expected_K;
    course_K = expected_K + alpha * d_K;
    if (h_s > 0.0) slope_K_per_s += beta * d_K / h_s;
    constexpr double rms_per_mean = 1.2533;  // of a normal distribution
    noise_K += noise_memory * (rms_per_mean * std::abs(d_K) - noise_K);
    noise_K = std::clamp(noise_K, stated_noise_K / 3.0, 3.0 * stated_noise_K);
    ++samples;
  }
};

}  // namespace spindle_twin::correction
