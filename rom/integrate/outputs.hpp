#pragma once

#include <Eigen/Core>

#include "rom/network.hpp"

namespace spindle_twin::rom {

/// What the network says at one instant, in the order of its key points, parts, deformations and contact pressures.
struct NetworkOutputs {
  Eigen::VectorXd key_points_K;
  Eigen::VectorXd part_mean_K;
  Eigen::VectorXd part_maximum_K;
  Eigen::VectorXd part_minimum_K;
  Eigen::VectorXd deformations_m;  ///< the first is the nose; + = spindle longer
  Eigen::VectorXd contact_pressures_Pa;
  Eigen::VectorXd candidates_K;  ///< scratch
};

/// Sizes the outputs for `network`; the only call here that allocates.
NetworkOutputs make_network_outputs(const Network& network);

/// y = H T, d = expansion · L (T − T_ref), p = p_assembly + P (T − T_ref) with T_ref the boundaries' reference
/// temperature; maximum and minimum of a part over its candidate points. Cycle-safe.
void evaluate_outputs(const Network& network, const Eigen::VectorXd& temperatures_K, NetworkOutputs& outputs,
                      double expansion = 1.0);

}  // namespace spindle_twin::rom
