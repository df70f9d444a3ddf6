#pragma once

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Moves the points on the chords of a part's outline onto the arcs and adds the sides between them to
/// `SectionMesh::bent_sides`. The part's elements run from `first_quad` to before `last_quad`.
void bend_sides(const PartOutline& outline, std::size_t first_quad, std::size_t last_quad, SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
