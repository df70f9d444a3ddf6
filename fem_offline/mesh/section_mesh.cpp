#include "fem_offline/mesh/section_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "fem_offline/mesh/bend_sides.hpp"
#include "fem_offline/mesh/gmsh_quads.hpp"
#include "fem_offline/mesh/mesh_quality.hpp"
#include "fem_offline/mesh/refine_quads.hpp"
#include "fem_offline/mesh/sharp_places.hpp"
#include "fem_offline/mesh/tensor_grid.hpp"

namespace spindle_twin::fem_offline {
namespace {

// Sine of the sharpest corner, and length over width, beyond which an element spoils the answer around it.
constexpr double least_corner_sine = 0.05;
constexpr double largest_aspect = 5000.0;

/// `halvings` of a mesh that was sound before: where two sides of one element lie on an arc, each halves the angle by
/// which they differ from one straight side, and spoils no more than before.
void check_shapes(const Part& named, const SectionMesh& mesh, std::size_t first_quad, std::size_t last_quad,
                  int halvings = 0) {
  const double least_sine = std::ldexp(least_corner_sine, -halvings);
  for (std::size_t q = first_quad; q < last_quad; ++q) {
    const ElementShape shape = shape_of(mesh, mesh.quads[q]);
    if (shape.scaled_jacobian < least_sine || shape.aspect > largest_aspect) {
      const Point& at = mesh.points[mesh.quads[q][0]];
      std::ostringstream message;
      message << "inverted or sliver element near (r, z) = (" << 1e3 * at.r_m << ", " << 1e3 * at.z_m
              << ") mm; corners need 3 to 177 degrees and sides a ratio below " << largest_aspect
              << ": move corners that nearly coincide, or change the element size";
      throw rom::InputError(named.where, "part." + named.name, message.str());
    }
  }
}

void check_volume(const Spindle& spindle, const Section& section, std::size_t part, const SectionMesh& mesh,
                  std::size_t first_quad) {
  const Part& named = spindle.parts[part];
  double volume_m3 = 0.0;
  for (std::size_t q = first_quad; q < mesh.quads.size(); ++q) {
    const auto& [a, b, c, d] = mesh.quads[q];
    volume_m3 += volume_within({mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]}, spindle.geometry);
  }
  const double outline_m3 = section.outlines[part].volume_m3;
  if (std::abs(volume_m3 - outline_m3) > 1e-6 * outline_m3) {
    std::ostringstream message;
    message << "the mesh holds " << volume_m3 << " m3, the outline " << outline_m3
            << " m3: corners closer than 1e-4 mm cannot be meshed";
    throw rom::InputError(named.where, "part." + named.name, message.str());
  }
}

}  // namespace

SectionMesh mesh_section(const Spindle& spindle, const Section& section, double element_limit) {
  SectionMesh mesh;
  const TensorGrid grid = make_tensor_grid(spindle, section, element_limit);
  for (std::size_t part = 0; part < section.outlines.size(); ++part) {
    const std::size_t first_quad = mesh.quads.size();
    if (is_axis_aligned(section.outlines[part])) {
      add_grid_cells(grid, section.outlines[part], part, mesh);
    } else {
      add_gmsh_quads(spindle, section, part, element_limit, mesh);
    }
    check_shapes(spindle.parts[part], mesh, first_quad, mesh.quads.size());
    check_volume(spindle, section, part, mesh, first_quad);
  }
  if (spindle.mesh.corner_size_m) {
    grade_towards(sharp_places(spindle, section, mesh), *spindle.mesh.corner_size_m, mesh);
  }
  for (int i = 0; i < spindle.mesh.halvings; ++i) halve_quads(mesh);
  for (std::size_t part = 0; part < section.outlines.size(); ++part) {
    const auto [first, last] = std::equal_range(mesh.part_of_quad.begin(), mesh.part_of_quad.end(), part);
    const auto first_quad = static_cast<std::size_t>(first - mesh.part_of_quad.begin());
    const auto last_quad = static_cast<std::size_t>(last - mesh.part_of_quad.begin());
    bend_sides(section.outlines[part], first_quad, last_quad, mesh);
    check_shapes(spindle.parts[part], mesh, first_quad, last_quad, spindle.mesh.halvings);
  }
  return mesh;
}

}  // namespace spindle_twin::fem_offline
