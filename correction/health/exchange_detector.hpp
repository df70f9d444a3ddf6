#pragma once

#include <Eigen/Core>
#include <vector>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Finds two channels that fit each other's movement much better than their own. y and m: reading and movement of the
/// uncorrected model, both freed from their running means, so that offsets and slow errors do not count; ⟨⟩: running
/// mean. What is left of y_i when m_j times its best factor is taken away, so that a wrong gain of the model does not
/// count either:
///   R_ij = ⟨y_i²⟩ − ⟨y_i m_j⟩² / ⟨m_j²⟩,  the factor positive
///   exchanged:   R_ij + R_ji < swap_share · (R_ii + R_jj)    and    R_ii, R_jj > swap_K²
/// Neighbours that move alike are never told apart, and need not be.
class ExchangeDetector {
 public:
  /// Allocates.
  explicit ExchangeDetector(std::size_t channels);

  /// The uncorrected model at the place of a channel, h_s >= 0 after the one before. [K], from any zero. May run in the
  /// cycle.
  void note_model(std::size_t channel, double uncorrected_K, double h_s, const HealthLimits& limits);
  /// A reading that is on its course, elapsed_s >= 0 after the one before. May run in the cycle.
  void note_reading(std::size_t channel, double reading_K, double elapsed_s, const HealthLimits& limits);
  /// Once per sample, after what is new was noted: moves all running means on by h_s. May run in the cycle: no
  /// allocation, n² products.
  void accumulate(double h_s, const HealthLimits& limits);

  /// Whether the two move as exchanged ones would. False without an uncorrected model. May run in the cycle.
  bool move_exchanged(std::size_t one, std::size_t other, const HealthLimits& limits) const;

 private:
  /// First-order high-pass: what is left of x when its running mean over tau is taken away.
  class HighPass {
   public:
    double pass(double x, double h_s, double tau_s);

   private:
    double mean_ = 0.0;
    bool started_ = false;
  };
  struct Movement {
    HighPass reading_filter, model_filter;
    double reading_K = 0.0;  ///< y
    double model_K = 0.0;    ///< m
  };
  double left_over_K2(std::size_t reading, std::size_t model) const;

  std::vector<Movement> movements_;
  Eigen::MatrixXd product_K2_;         // ⟨y_i m_j⟩
  Eigen::VectorXd reading_square_K2_;  // ⟨y_i²⟩
  Eigen::VectorXd model_square_K2_;    // ⟨m_j²⟩
};

}  // namespace spindle_twin::correction
