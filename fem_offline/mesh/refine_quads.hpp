#pragma once

#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Cuts every quadrilateral into four by the middles of its sides, which are straight still: the coarser mesh's
/// functions are among the finer one's.
void halve_quads(SectionMesh& mesh);

/// Makes elements small towards places that are points of the mesh: while a side that ends there is longer than
/// `size_m`, every side that ends there is cut at a third of its length and every quadrilateral around the place into
/// three, one at the place and two behind it. Nothing else changes, so what matched along a contact matches again.
void grade_towards(const std::vector<Point>& places, double size_m, SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
