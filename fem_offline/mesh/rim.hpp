#pragma once

#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// A straight stretch of a part's rim between two corners or piece ends, and the element size along it.
struct RimSide {
  Point start, end;
  double size_m = 0.0;
};

using Rim = std::vector<std::vector<RimSide>>;  ///< closed rings of one face: the outer one, then the holes

/// The rim of one face of a part: cut at the ends of its pieces; size of the part, at a contact the finer one of both
/// parts and of `contact_size_m`, and no more than the thickness of the part there over `cells_across`.
Rim make_rim(const Spindle& spindle, const Section& section, std::size_t part, const OutlineFace& face);

}  // namespace spindle_twin::fem_offline
