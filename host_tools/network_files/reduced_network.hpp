#pragma once

#include "host_tools/network_files/schedule_course.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

struct ReducedNetwork {
  rom::Network network;
  double largest_error_K = 0.0;       ///< of any key point or part's mean, at any instant that was compared
  double largest_node_error_K = 0.0;  ///< of any node of the full network
};

/// A network whose nodes are a few of the given one's, I, and which follows that one along this course, at nodes and
/// outputs alike, when both start at rest:
///   T ≈ Ψ T_I,  C_r = ΨᵀCΨ,  K_r = ΨᵀKΨ,  F_r = ΨᵀF,  B_r = ΨᵀB,  rows H_r = HΨ
///   Ψ = V V_I⁻¹, V the even field and the leading left singular vectors of the rises along the course, less their mean
/// over the nodes (proper orthogonal decomposition); I by QR with column pivoting of Vᵀ. Ψ1 = 1, so an even field stays
/// even, heats and capacities keep their sums, and symmetric matrices stay what they are.
/// Nodes are added until every key point and part's mean is within tolerance_K (> 0) of the full network's, and every
/// node within 4 times of that, at every instant: from 0.05 s behind each row on, in intervals of a half more each up
/// to 60 s. Along another course the error is another. Where that takes nearly all nodes: the network as it is, with
/// error 0. Laws are held as in `course`. std::runtime_error if the full network has no solution along the course.
/// Takes about what a simulation of it does.
ReducedNetwork reduced_network(const rom::Network& network, const ScheduleCourse& course, double tolerance_K);

}  // namespace spindle_twin::host_tools
