#pragma once

#include <Eigen/Core>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// A description whose elements are cut in four, `times` times over.
Spindle with_halved_elements(Spindle spindle, int times);

/// Error of every output of the model's own mesh, from meshes with every element cut in four once and twice
/// (mesh/error_left.hpp): the largest over the warm-up of the operating state from the reference temperature (intervals
/// 1, 1, 2, ... 32 s) and its steady end; into the certificate's `mesh`. Above 4000 unknowns the second cut is left
/// out and order 1 taken.
void measure_mesh_error(const FeModel& model, const Progress& progress, rom::Certificate& certificate);

/// The same of the steady state alone, with the second cut up to 30 000 unknowns, in the order of OutputLayout
/// (reduce/trajectory.hpp), each with its sign: what to add to the model's outputs.
Eigen::VectorXd steady_mesh_error(const FeModel& model);

}  // namespace spindle_twin::fem_offline
