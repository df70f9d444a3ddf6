#pragma once

#include <Eigen/Core>
#include <vector>

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// The segments of all circuits in one list, each circuit's in the order of positive flow. M segments.
struct CoolantSegments {
  std::vector<int> conductance;  ///< per segment
  std::vector<int> inlet;        ///< per segment, the environment at its circuit's inlet
  std::vector<int> first;        ///< per circuit its first segment, and behind them M
  Eigen::VectorXd area_m2;       ///< per segment, 1ᵀKⱼ1 of the matrix that takes the heat

  Eigen::Index count() const { return static_cast<Eigen::Index>(conductance.size()); }
};

/// Areas are those of the conductances; a model whose matrices know them better to the last digit overwrites them.
CoolantSegments coolant_segments(const Boundaries& boundaries);

/// Strictly triangular U (in flow order) with T_in − T_inlet = U (T_wall − T_inlet), M x M: what segments upstream do
/// to the liquid that enters a segment. Zero flow gives the limit ṁ → 0, where the liquid leaves at the wall's
/// temperature; it then carries no heat. Cycle-safe when `upstream` is sized.
void coolant_upstream(const CoolantSegments& segments, const BoundaryValues& values, Eigen::MatrixXd& upstream);

/// What one W/m²K more of the segment `changed` does to Σ_s P_s g_s r_s, with r_s the rise of the liquid that enters
/// segment s above its inlet: Σ_s P_s weights_s. `wall_rise_K`: area means of the walls above the inlet, one per
/// segment. Cycle-safe when `weights` (M) is sized.
void coolant_slope(const CoolantSegments& segments, const BoundaryValues& values, const Eigen::VectorXd& wall_rise_K,
                   std::size_t circuit, int changed, Eigen::VectorXd& weights);

/// Per circuit the outlet temperature and the heat taken, Σ q_s = |ṁ| c (T_out − T_inlet).
struct CoolantOutlets {
  Eigen::VectorXd outlet_K;
  Eigen::VectorXd heat_W;
};

/// `wall_K`: area means of the wetted walls, one per segment. Cycle-safe when `outlets` is sized.
void march_coolant(const CoolantSegments& segments, const BoundaryValues& values, const Eigen::VectorXd& wall_K,
                   CoolantOutlets& outlets);

}  // namespace spindle_twin::rom
