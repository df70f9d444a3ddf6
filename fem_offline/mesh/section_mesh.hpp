#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "fem_offline/mesh/element_sizes.hpp"
#include "fem_offline/mesh/section.hpp"

namespace spindle_twin::fem_offline {

/// A side of an element that is an arc about the centre.
struct BentSide {
  std::size_t a = 0, b = 0;  ///< points, a < b
  Point centre;
};

/// Quadrilaterals of all parts, straight-sided but for the bent sides. Parts share no point, also where they touch: a
/// contact is a conductance between two surfaces, not a common temperature.
struct SectionMesh {
  std::vector<Point> points;
  std::vector<std::array<std::size_t, 4>> quads;  ///< counter-clockwise (r to the right, z up)
  std::vector<std::size_t> part_of_quad;
  std::vector<BentSide> bent_sides = {};
};

/// Meshes every part apart with elements of about the size asked for (MeshSettings, Part::element_size_m). Parts with
/// sides along r and z take cells of one tensor grid (lines at every corner and piece end), so that neighbours match;
/// others go through gmsh. Every end of a BoundaryPiece is a mesh point. Throws rom::InputError naming the part whose
/// mesh would not fill it or would hold an inverted or sliver element, and before meshing when the sizes ask for more
/// than `element_limit`.
SectionMesh mesh_section(const Spindle& spindle, const Section& section, double element_limit = most_elements);

/// Two coordinates closer than this are one.
inline constexpr double same_place_m = 1e-7;

/// The same for points of one place.
using PlaceKey = std::pair<long long, long long>;
inline PlaceKey place_key(const Point& at) {
  return {std::llround(at.r_m / same_place_m), std::llround(at.z_m / same_place_m)};
}

inline double distance_m(const Point& a, const Point& b) { return std::hypot(b.r_m - a.r_m, b.z_m - a.z_m); }

}  // namespace spindle_twin::fem_offline
