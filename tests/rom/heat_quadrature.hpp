#pragma once

#include <Eigen/Core>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::rom::tests {

/// The heat that a network gives to its surroundings in one step with inputs held, from its matrices and the
/// temperatures at both ends of the step alone: with f the heat of all films at one instant,
///   heat = h/2 (f₀ + f₁) + h²/10 (f₀' − f₁') + h³/120 (f₀'' + f₁''),   T' = C⁻¹ (B q + p − K₀ T − ...), T'' = −C⁻¹ K
///   T'
/// the two-point formula of order 6 (Hermite), exact enough where h is short beside the network's time constants.
/// Networks without physical laws and coolant circuits.
class HeatQuadrature {
 public:
  explicit HeatQuadrature(const Network& network);

  /// In J. No heap call.
  double given_away_J(double period_s, const BoundaryValues& values, const Eigen::VectorXd& before_K,
                      const Eigen::VectorXd& after_K);

 private:
  struct Film {
    Eigen::VectorXd column;  ///< F Fᵀ 1, m²
    int environment = -1;
  };
  struct Instant {
    double heat_W = 0.0, rate_W_per_s = 0.0, curvature_W_per_s2 = 0.0;
  };
  Instant at(const BoundaryValues& values, const Eigen::VectorXd& nodes_K);
  double film_W(const BoundaryValues& values, const Eigen::VectorXd& nodes_K, double inputs) const;
  void rate(const BoundaryValues& values, const Eigen::VectorXd& nodes_K, double inputs, Eigen::VectorXd& to);

  const Network network_;
  std::vector<Film> films_;  ///< one per conductance
  Eigen::MatrixXd inverse_capacity_;
  Eigen::VectorXd first_, second_, heat_W_, through_;
};

}  // namespace spindle_twin::rom::tests
