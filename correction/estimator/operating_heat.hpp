#pragma once

#include <Eigen/Core>
#include <vector>

#include "correction/estimator/thermal_groups.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// All nominal heats together, each by its size, in W.
double nominal_heats_W(const rom::Network& network);

/// What flows through each group in the steady state at the described operating state, in W: half of all that goes in
/// and out over its border, its own sources included. With x the steady rises, K₀ + Σ g F Fᵀ x = B q (surroundings at
/// the reference temperature), E the part of that matrix between bodies:
///   through_g = ½ (Σ_s |1_gᵀ B_s q_s| + Σ_{i in g, j not} |E_ij (x_i − x_j)| + |1_gᵀ (B q − E x)|)
/// Of lumped networks, whose nodes are bodies: at a node through which a heat passes that heat. All heats together
/// for each group where there is no steady state. `groups` as of thermal_groups. Allocates; not for the cycle.
std::vector<double> heat_through_groups_W(const rom::Network& network, const std::vector<ThermalGroup>& groups);

}  // namespace spindle_twin::correction
