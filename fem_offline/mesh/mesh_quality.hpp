#pragma once

#include <array>
#include <string>
#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Shape of one quadrilateral. The scaled Jacobian is the least sine of its corners, 1 for a rectangle, below 0 when
/// inverted; the aspect is its longest over its shortest side.
struct ElementShape {
  double scaled_jacobian = 1.0;
  double aspect = 1.0;
};

ElementShape shape_of(const SectionMesh& mesh, const std::array<std::size_t, 4>& quad);

/// Shapes of all elements of one part.
struct PartQuality {
  std::string part;
  std::size_t cells = 0;
  double least_scaled_jacobian = 1.0;
  double largest_scaled_jacobian = 0.0;
  double mean_scaled_jacobian = 0.0;
  double largest_aspect = 1.0;
  double least_side_m = 0.0;
  double longest_side_m = 0.0;
};

/// One entry per part of the description.
std::vector<PartQuality> mesh_quality(const Spindle& spindle, const SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
