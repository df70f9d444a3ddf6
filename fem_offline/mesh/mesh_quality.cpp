#include "fem_offline/mesh/mesh_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::fem_offline {
namespace {

struct Sides {
  double shortest_m = std::numeric_limits<double>::max();
  double longest_m = 0.0;
};

Sides sides_of(const SectionMesh& mesh, const std::array<std::size_t, 4>& quad) {
  Sides sides;
  for (std::size_t k = 0; k < 4; ++k) {
    const Point &a = mesh.points[quad[k]], &b = mesh.points[quad[(k + 1) % 4]];
    const double length_m = std::hypot(b.r_m - a.r_m, b.z_m - a.z_m);
    sides.shortest_m = std::min(sides.shortest_m, length_m);
    sides.longest_m = std::max(sides.longest_m, length_m);
  }
  return sides;
}

}  // namespace

ElementShape shape_of(const SectionMesh& mesh, const std::array<std::size_t, 4>& quad) {
  ElementShape shape;
  for (std::size_t k = 0; k < 4; ++k) {
    const Point& before = mesh.points[quad[(k + 3) % 4]];
    const Point& at = mesh.points[quad[k]];
    const Point& after = mesh.points[quad[(k + 1) % 4]];
    const double r1 = after.r_m - at.r_m, z1 = after.z_m - at.z_m;
    const double r2 = before.r_m - at.r_m, z2 = before.z_m - at.z_m;
    const double lengths_m2 = std::hypot(r1, z1) * std::hypot(r2, z2);
    const double sine = lengths_m2 > 0.0 ? (r1 * z2 - r2 * z1) / lengths_m2 : -1.0;
    shape.scaled_jacobian = std::min(shape.scaled_jacobian, sine);
  }
  const Sides sides = sides_of(mesh, quad);
  shape.aspect = sides.shortest_m > 0.0 ? sides.longest_m / sides.shortest_m : std::numeric_limits<double>::max();
  return shape;
}

std::vector<PartQuality> mesh_quality(const Spindle& spindle, const SectionMesh& mesh) {
  std::vector<PartQuality> qualities;
  for (const Part& part : spindle.parts) {
    PartQuality quality;
    quality.part = part.name;
    quality.least_side_m = std::numeric_limits<double>::max();
    qualities.push_back(std::move(quality));
  }
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    PartQuality& quality = qualities[mesh.part_of_quad[q]];
    const ElementShape shape = shape_of(mesh, mesh.quads[q]);
    const Sides sides = sides_of(mesh, mesh.quads[q]);
    ++quality.cells;
    quality.least_scaled_jacobian = std::min(quality.least_scaled_jacobian, shape.scaled_jacobian);
    quality.largest_scaled_jacobian = std::max(quality.largest_scaled_jacobian, shape.scaled_jacobian);
    quality.mean_scaled_jacobian += shape.scaled_jacobian;
    quality.largest_aspect = std::max(quality.largest_aspect, shape.aspect);
    quality.least_side_m = std::min(quality.least_side_m, sides.shortest_m);
    quality.longest_side_m = std::max(quality.longest_side_m, sides.longest_m);
  }
  for (PartQuality& quality : qualities) quality.mean_scaled_jacobian /= static_cast<double>(quality.cells);
  return qualities;
}

}  // namespace spindle_twin::fem_offline
