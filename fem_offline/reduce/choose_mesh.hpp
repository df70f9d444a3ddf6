#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "fem_offline/reduce/reduce.hpp"

namespace spindle_twin::fem_offline {

/// One mesh on the way, with what was made finer last: a part's name, "corners", or nothing for the description's own.
struct TriedMesh {
  std::string finer;
  std::size_t unknowns = 0;
  double error_m = 0.0;         ///< of the deformation that errs most, steady at the operating state
  double largest_step_m = 0.0;  ///< the most that any single refinement would still change a deformation
};

struct MeshChoice {
  Spindle spindle;  ///< the description with the sizes found
  std::vector<TriedMesh> meshes;
  bool reached = false;
};

/// Makes the mesh finer where that moves the deformations most for the unknowns it costs, at corners (to a third of
/// their size) or in one part (to six tenths of its size), until the steady deformations err by less than `wanted_m`
/// and no single refinement moves one by more: errors that happen to cancel do not count as small. They err against the
/// same mesh with elements of one degree more and corners down to a 200th of the element size. Stops, not reached, at
/// `most_times` the unknowns of the description's own mesh. Throws rom::InputError for a description without
/// deformations.
MeshChoice choose_mesh(const Spindle& spindle, double wanted_m, double most_times, const Progress& progress);

}  // namespace spindle_twin::fem_offline
