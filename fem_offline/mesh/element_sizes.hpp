#pragma once

#include "fem_offline/mesh/section.hpp"

namespace spindle_twin::fem_offline {

/// Element size asked for inside a part: its own or the mesh's. [m]
inline double size_of(const Spindle& spindle, std::size_t part) {
  return spindle.parts[part].element_size_m.value_or(spindle.mesh.element_size_m);
}

/// Elements may grow by this much per length away from a finer place.
inline constexpr double size_growth = 0.3;

/// More elements than this are refused before meshing: a slip in a size, not a model.
inline constexpr double most_elements = 2e6;

}  // namespace spindle_twin::fem_offline
