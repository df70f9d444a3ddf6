#pragma once

#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Points of the mesh around which the exact solution is singular, so that elements of one size give errors of order 1
/// there whatever their degree: corners that go into the material (of the bonded body, or of one part), and the ends of
/// held faces where the outline goes straight on or round less than a right corner. Joints of an arc's chords are none.
/// `mesh` has straight sides still.
std::vector<Point> sharp_places(const Spindle& spindle, const Section& section, const SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
