#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/reduce/parameter_box.hpp"
#include "rom/boundaries.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {

/// The FE model tested with a Galerkin basis V of n columns; all matrices dense, n x n unless said otherwise:
///   C dT/dt = −(K₀ + Σⱼ gⱼ Kⱼ) T + Σⱼ gⱼ (Kⱼ 1) T_env(j) + B q
struct DenseModel {
  Eigen::MatrixXd capacity;
  Eigen::MatrixXd conduction;
  std::vector<Eigen::MatrixXd> conductance_terms;
  Eigen::MatrixXd walls_m2;             ///< n x conductances: Kⱼ 1, zero for exchange between bodies
  Eigen::MatrixXd source_distribution;  ///< n x sources
  Eigen::VectorXd uniform;              ///< n; the field that is 1 everywhere
};

/// Conduction and drive of a model under held inputs: C dT/dt = drive − conduction T, with T the rise above `zero_K`.
/// What a circuit's liquid carries from segment to segment is in both, and makes the conduction unsymmetric.
struct HeldModel {
  Eigen::MatrixXd conduction;
  Eigen::VectorXd drive;
};

void hold_inputs(const DenseModel& model, const rom::Boundaries& boundaries, const rom::CoolantSegments& segments,
                 const rom::BoundaryValues& values, double zero_K, HeldModel& held);

/// A random state of the machine: any speed, load and coolant flow of the box, environments `spread_K` about the
/// description's. Every circuit flows, since steady fields are asked for and without flow there may be none.
rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, double spread_K,
                                 RandomStream& random);

}  // namespace spindle_twin::fem_offline
