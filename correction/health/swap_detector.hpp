#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Finds two channels that move like each other's place in the uncorrected model, from the start or later. y and m:
/// reading and model, both freed from their running means over τ = 60, 300 and 1200 s, so that offsets and slow errors
/// do not count; ⟨⟩: sums over time, fading over swap_memory_s. What is left of y_i when m_j times its best factor is
/// taken away, so that a wrong gain of the model does not count either:
///   g_ij = ⟨y_i m_j⟩ / ⟨m_j²⟩ > 0,        R_ij = ⟨y_i²⟩ − g_ij ⟨y_i m_j⟩
/// With N = ⟨m²⟩² / ⟨m⁴⟩ / τ independent samples, the variance of each fit profiled out, and r the least that counts,
/// (swap_floor² ⟨y²⟩ + noise²), the gain of likelihood of i in the place of j against its own is
///   a_ij = Σ_τ N ln (R_ii + r_i) / (R_ij + r_i)
/// and ln of the gains is 0 ± swap_gain on the middle scale, less sure where y hardly moves:
///   Λ = a_ij + a_ji + Σ± ln² g / (swap_gain² + swap_K² / mean y²)      (own places +, swapped ones −)
/// Two are swapped where Λ > swap_limit, a_ij > 0, a_ji > 0, and either fits the other's place at every scale:
/// R_ij <= swap_fit² ⟨y_i²⟩ + noise². Neighbours that move alike are never told apart, and need not be.
class SwapDetector {
 public:
  static constexpr std::array scales_s{60.0, 300.0, 1200.0};  ///< speed steps; seats and jackets; the whole spindle

  /// Two channels, each -1 where none are swapped.
  struct Pair {
    int one = -1;
    int other = -1;
  };

  /// 1σ of each channel's readings, > 0. Allocates; nothing else here does.
  explicit SwapDetector(const std::vector<double>& noise_K);

  /// The uncorrected model at the place of a channel, h_s >= 0 after the one before; for all channels before the
  /// readings. [K], from any zero. May run in the cycle.
  void note_model(std::size_t channel, double uncorrected_K, double h_s);
  /// A reading that is on its course, elapsed_s >= 0 after the one before. `counts`: the channel is in use; else only
  /// its running means are carried on. May run in the cycle: 3 n products.
  void note_reading(std::size_t channel, double reading_K, double elapsed_s, bool counts, const HealthLimits& limits);

  /// Its readings may be of another place from now on: their movement is gathered anew, from that of the model at its
  /// own place on. May run in the cycle.
  void forget(std::size_t channel);

  /// The pair among the channels in use that is swapped with most evidence, none without an uncorrected model. May
  /// run in the cycle: n² logarithms.
  Pair find(const std::vector<bool>& in_use, const HealthLimits& limits) const;
  /// The channel in use that this one is swapped with most likely, where other evidence has blamed this one already:
  /// Λ > swap_support will do. -1: none. May run in the cycle.
  int partner_of(std::size_t channel, const std::vector<bool>& in_use, const HealthLimits& limits) const;
  /// What speaks for the two being swapped, Λ; −∞ where one of the other conditions is not met. May run in the cycle.
  double evidence(std::size_t one, std::size_t other, const HealthLimits& limits) const;

 private:
  /// First-order high-pass: what is left of x when its running mean over tau is taken away.
  class HighPass {
   public:
    /// `first`: what is left of the first x.
    double pass(double x, double h_s, double tau_s, double first = 0.0);

   private:
    double mean_ = 0.0;
    bool started_ = false;
  };
  struct Scale {
    std::vector<HighPass> reading_filters, model_filters;
    Eigen::VectorXd model_K;            ///< m
    Eigen::VectorXd reading_square_K2;  ///< ⟨y_i²⟩
    Eigen::MatrixXd product_K2;         ///< ⟨y_i m_j⟩
    Eigen::MatrixXd model_square_K2;    ///< ⟨m_j²⟩ at the readings of i
    Eigen::VectorXd model_fourth_K4;    ///< ⟨m_i⁴⟩
  };
  /// How a reading fits a place at one scale.
  struct Fit {
    double gain = 0.0;
    double left_over_K2 = 0.0;
  };
  static Fit fit(const Scale& scale, Eigen::Index reading, Eigen::Index place);
  static double independent_samples(const Scale& scale, double scale_s, Eigen::Index place);
  double gain_penalty(Eigen::Index reading, Eigen::Index place, const HealthLimits& limits) const;

  std::array<Scale, scales_s.size()> scales_;
  Eigen::VectorXd noise_K_;
  Eigen::VectorXd seen_s_;  // time that the sums of a channel stand for
};

}  // namespace spindle_twin::correction
