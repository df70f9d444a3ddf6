#include "fem_offline/mesh/section_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "fem_offline/mesh/gmsh_quads.hpp"
#include "fem_offline/mesh/tensor_grid.hpp"

namespace spindle_twin::fem_offline {
namespace {

// Sine of the sharpest corner, and length over width, beyond which an element spoils the answer around it.
constexpr double least_corner_sine = 0.05;
constexpr double largest_aspect = 5000.0;

struct Shape {
  double least_corner_sine = std::numeric_limits<double>::max();
  double aspect = 0.0;
};

Shape shape_of(const SectionMesh& mesh, const std::array<std::size_t, 4>& quad) {
  Shape shape;
  double shortest_m = std::numeric_limits<double>::max();
  double longest_m = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Point& before = mesh.points[quad[(k + 3) % 4]];
    const Point& at = mesh.points[quad[k]];
    const Point& after = mesh.points[quad[(k + 1) % 4]];
    const double r1 = after.r_m - at.r_m, z1 = after.z_m - at.z_m;
    const double r2 = before.r_m - at.r_m, z2 = before.z_m - at.z_m;
    const double length1_m = std::hypot(r1, z1), length2_m = std::hypot(r2, z2);
    shortest_m = std::min(shortest_m, length1_m);
    longest_m = std::max(longest_m, length1_m);
    const double sine = length1_m * length2_m > 0.0 ? (r1 * z2 - r2 * z1) / (length1_m * length2_m) : -1.0;
    shape.least_corner_sine = std::min(shape.least_corner_sine, sine);
  }
  shape.aspect = shortest_m > 0.0 ? longest_m / shortest_m : std::numeric_limits<double>::max();
  return shape;
}

/// Pappus: ∮ π r² dz over the quad's rim.
double volume_of(const SectionMesh& mesh, const std::array<std::size_t, 4>& quad) {
  double volume_m3 = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Point& a = mesh.points[quad[k]];
    const Point& b = mesh.points[quad[(k + 1) % 4]];
    volume_m3 += std::numbers::pi / 3.0 * (a.r_m * a.r_m + a.r_m * b.r_m + b.r_m * b.r_m) * (b.z_m - a.z_m);
  }
  return volume_m3;
}

void check_part(const Spindle& spindle, const Section& section, std::size_t part, const SectionMesh& mesh,
                std::size_t first_quad) {
  const Part& named = spindle.parts[part];
  double volume_m3 = 0.0;
  for (std::size_t q = first_quad; q < mesh.quads.size(); ++q) {
    volume_m3 += volume_of(mesh, mesh.quads[q]);
    const Shape shape = shape_of(mesh, mesh.quads[q]);
    if (shape.least_corner_sine < least_corner_sine || shape.aspect > largest_aspect) {
      const Point& at = mesh.points[mesh.quads[q][0]];
      std::ostringstream message;
      message << "inverted or sliver element near (r, z) = (" << 1e3 * at.r_m << ", " << 1e3 * at.z_m
              << ") mm; corners need 3 to 177 degrees and sides a ratio below " << largest_aspect
              << ": move corners that nearly coincide, or change the element size";
      throw rom::InputError(named.where, named.name, message.str());
    }
  }
  const double outline_m3 = section.outlines[part].volume_m3;
  if (std::abs(volume_m3 - outline_m3) > 1e-6 * outline_m3) {
    std::ostringstream message;
    message << "the mesh holds " << volume_m3 << " m3, the outline " << outline_m3
            << " m3: corners closer than 1e-4 mm cannot be meshed";
    throw rom::InputError(named.where, named.name, message.str());
  }
}

}  // namespace

SectionMesh mesh_section(const Spindle& spindle, const Section& section) {
  SectionMesh mesh;
  const TensorGrid grid = make_tensor_grid(spindle, section);
  for (std::size_t part = 0; part < section.outlines.size(); ++part) {
    const std::size_t first_quad = mesh.quads.size();
    if (is_axis_aligned(section.outlines[part])) {
      add_grid_cells(grid, section.outlines[part], part, mesh);
    } else {
      add_gmsh_quads(spindle, section, part, mesh);
    }
    check_part(spindle, section, part, mesh, first_quad);
  }
  return mesh;
}

}  // namespace spindle_twin::fem_offline
