#pragma once

#include <Eigen/Core>

#include "firmware/cycle/snapshot.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// Where the nodes of a network begin that is to go on from what another network of the same spindle says: its key
/// points as there, the mean of each part near the other's hottest point of that part, and in between as little heat
/// as possible flowing between the nodes (conduction and joints at their nominal values, nothing to the surroundings).
/// [K] Without any key point that is a number the result is empty. Allocates; not for the cycle.
Eigen::VectorXd start_field(const rom::Network& network, const Snapshot& said);

}  // namespace spindle_twin::firmware
