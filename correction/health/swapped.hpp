#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// First-order high-pass: what is left of x when its running mean over tau is taken away.
struct HighPass {
  double mean = 0.0;
  bool started = false;

  double pass(double x, double h_s, double tau_s) {
    if (!started) mean = x;
    started = true;
    const double out = x - mean;
    mean += (1.0 - std::exp(-h_s / tau_s)) * out;
    return out;
  }
};

/// Two channels fit each other's movement much better than their own. y and m: reading and model's movement, both freed
/// from their running means, so that offsets and slow errors do not count; ⟨⟩: running mean. What is left of y_i when
/// m_j times its best factor is taken away, so that a wrong gain of the model does not count either:
///   R_ij = ⟨y_i²⟩ − ⟨y_i m_j⟩² / ⟨m_j²⟩,  the factor positive
///   swapped:   R_ij + R_ji < share · (R_ii + R_jj)    and    R_ii, R_jj > swap²
/// Neighbours that move alike are never told apart, and need not be. Runs in the cycle.
inline double left_over(double y_y, double y_m, double m_m) {
  return y_m > 0.0 && m_m > 0.0 ? std::max(0.0, y_y - y_m * y_m / m_m) : y_y;
}

inline bool fits_swapped(double own_i_K2, double own_j_K2, double cross_ij_K2, double cross_ji_K2,
                         const HealthLimits& limits) {
  const double least_K2 = limits.swap_K * limits.swap_K;
  return own_i_K2 > least_K2 && own_j_K2 > least_K2 &&
         cross_ij_K2 + cross_ji_K2 < limits.swap_share * (own_i_K2 + own_j_K2);
}

/// The same at one instant, with what the others say of each place, t = reading − misfit; what is left of the misfits:
///   (|y_i − t_j| + |y_j − t_i|) / (|misfit_i| + |misfit_j|)
/// For channels that contradict all others together. Exchanged ones do so by as much, one up and one down; one that
/// drifts by itself bends what is said of a neighbour, but less: infinite where the misfits differ by more than
/// exchange_alike.
inline double left_when_exchanged(double y_i_K, double misfit_i_K, double y_j_K, double misfit_j_K,
                                  const HealthLimits& limits) {
  const double i_K = std::abs(misfit_i_K), j_K = std::abs(misfit_j_K);
  const bool alike = misfit_i_K * misfit_j_K < 0.0 && std::min(i_K, j_K) > limits.exchange_alike * std::max(i_K, j_K);
  if (!alike) return std::numeric_limits<double>::infinity();
  return (std::abs(y_i_K - y_j_K + misfit_j_K) + std::abs(y_j_K - y_i_K + misfit_i_K)) / (i_K + j_K);
}

}  // namespace spindle_twin::correction
