#pragma once

#include <Eigen/Core>
#include <vector>

#include "correction/estimator/thermal_groups.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Ways in which the spindle may have been warmer, at a start of which nothing is known, than the model's start: one
/// parameter of the estimator each, in K at its largest.
struct StartShape {
  std::string name;
  Eigen::VectorXd rise_K;  ///< N, largest absolute value 1
};

// A start of which readings say that it was another. Of their spread about it:
/// deviations of one reading within which the sensors stand at one temperature,
inline constexpr double start_isothermal = 3.0;
/// σ of the steady rises, whose hottest place no sensor sees, and of each group,
inline constexpr double open_rises_share = 2.0, open_groups_share = 1.0;
/// and what a group's own temperature differences add to either. Larger shares change nothing (warm_restart of
/// tests/bench/reality_campaign), smaller ones leave the truth outside.
inline constexpr double start_missed_share = 0.3;

/// In this order:
///   uniform   1 at every node
///   running   the steady rise at the described operating state, K x = B q
///   stopped   what is left of that rise after a quarter of an hour without heat
///   one per thermal group: 1 at its nodes
/// Running and stopped are left out where the network has no heat or no steady state; groups where there is only one.
/// Allocates; not for the cycle.
std::vector<StartShape> start_shapes(const rom::Network& network, const rom::NetworkOperator& coordinates,
                                     const std::vector<ThermalGroup>& groups);

}  // namespace spindle_twin::correction
