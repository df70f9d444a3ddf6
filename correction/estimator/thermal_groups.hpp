#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Parts of a spindle that share one temperature within a few minutes.
struct ThermalGroup {
  std::string name;               ///< of its largest part by heat capacity; of a network without parts, of its node
  Eigen::VectorXd indicator;      ///< N: 1 at its nodes, 0 elsewhere
  double capacity_J_per_K = 0.0;  ///< 1_gᵀ C 1_g
};

/// The network's nodes in at most `most` groups: at first every part is one (a node without part for itself), then the
/// two that exchange fastest become one, rate = G (1/C_a + 1/C_b) with G = −1_aᵀ K 1_b at the nominal conductances,
/// until so few are left. Every node is in one group. Allocates; not for the cycle. most >= 1.
std::vector<ThermalGroup> thermal_groups(const rom::Network& network, std::size_t most);

}  // namespace spindle_twin::correction
