#pragma once

#include <Eigen/Core>
#include <vector>

#include "rom/integrate/coolant.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "rom/network.hpp"

namespace spindle_twin::rom {

/// Per conductance the temperature that its film meets: of its environment, and of the segments of coolant circuits
/// that of the liquid entering; 0 between bodies.
class MetTemperatures {
 public:
  explicit MetTemperatures(const Network& network);
  /// met_K: one per conductance. Cycle-safe.
  void evaluate(const BoundaryValues& values, const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& met_K);

 private:
  std::vector<int> environment_;  ///< per conductance
  CoolantSegments segments_;
  Eigen::MatrixXd walls_;     ///< N x M: the area mean of a segment's wall
  Eigen::MatrixXd upstream_;  ///< U
  Eigen::VectorXd above_inlet_K_, warmed_K_;
};

/// The heats of heat_flows() that go along paths, for the cycle: what does not change is multiplied out before. With p
/// a path from body A by conductance j, and all else as there:
///   heat(p)  = gⱼ rowₚ (T − 1 T_env(j)),   rowₚ = 1_Aᵀ Fⱼ Fⱼᵀ
///   made(A)  = 1_Aᵀ (B q + node heat) − 1_Aᵀ K₀ T     what A is given otherwise: by sources, and by bodies without a
///                                                     contact, of a built network rounding
///   stored(A) = made(A) − Σ heat(p) of the paths from A + Σ heat(p) of those to A
class FlowRows {
 public:
  FlowRows(const Network& network, const std::vector<Body>& bodies, const std::vector<FlowPath>& paths);

  Eigen::Index paths() const { return static_cast<Eigen::Index>(conductance_.size()); }
  Eigen::Index bodies() const { return conduction_.rows(); }

  /// At these node temperatures, with `values` of the same temperatures (LawTerms::at_temperatures): heat_W per path,
  /// in its sense, and made_W per body. Cycle-safe where both are sized.
  void evaluate(const BoundaryValues& values, const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& heat_W,
                Eigen::VectorXd& made_W);

 private:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  double datum_K_;
  std::vector<Eigen::Index> conductance_;  ///< per path
  Rows rows_m2_;                           ///< paths x N
  Eigen::VectorXd to_environment_m2_;      ///< per path rowₚ 1, between bodies 0
  Rows conduction_, sources_, gather_;     ///< bodies x N, sources, N
  MetTemperatures met_;
  Eigen::VectorXd rises_K_, met_K_;
};

}  // namespace spindle_twin::rom
