#include "fem_offline/mesh/tensor_grid.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace spindle_twin::fem_offline {
namespace {

template <typename Visit>
void for_each_ring(const PartOutline& outline, Visit visit) {
  for (const OutlineFace& face : outline.faces) {
    visit(face.outer);
    for (const Polygon& hole : face.holes) visit(hole);
  }
}

std::vector<double> without_doubles(std::vector<double> lines) {
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end(), [](double a, double b) { return b - a < same_place_m; }),
              lines.end());
  return lines;
}

std::vector<double> subdivided(const std::vector<double>& lines, double element_size_m) {
  std::vector<double> fine;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    const double length_m = lines[i + 1] - lines[i];
    const int cells = std::max(1, static_cast<int>(std::ceil(length_m / element_size_m - 1e-6)));
    for (int k = 0; k < cells; ++k) fine.push_back(lines[i] + length_m * k / cells);
  }
  if (!lines.empty()) fine.push_back(lines.back());
  return fine;
}

/// Even-odd rule over all rings; `at` is a cell's centre and so never on a ring.
bool is_inside(const PartOutline& outline, const Point& at) {
  bool inside = false;
  for_each_ring(outline, [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      if ((a.z_m > at.z_m) == (b.z_m > at.z_m)) continue;
      if (at.r_m < a.r_m + (b.r_m - a.r_m) * (at.z_m - a.z_m) / (b.z_m - a.z_m)) inside = !inside;
    }
  });
  return inside;
}

}  // namespace

bool is_axis_aligned(const PartOutline& outline) {
  bool aligned = true;
  for_each_ring(outline, [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      const bool along_r = std::abs(a.z_m - b.z_m) < same_place_m;
      const bool along_z = std::abs(a.r_m - b.r_m) < same_place_m;
      aligned = aligned && (along_r || along_z);
    }
  });
  return aligned;
}

TensorGrid make_tensor_grid(const Spindle& spindle, const Section& section) {
  std::vector<double> r_m, z_m;
  const auto add = [&](const Point& point) {
    r_m.push_back(point.r_m);
    z_m.push_back(point.z_m);
  };
  std::vector<bool> aligned;
  for (const PartOutline& outline : section.outlines) {
    aligned.push_back(is_axis_aligned(outline));
    if (!aligned.back()) continue;
    for_each_ring(outline, [&](const Polygon& ring) { std::for_each(ring.begin(), ring.end(), add); });
  }
  if (r_m.empty()) return {};
  for (const BoundaryPiece& piece : section.pieces) {
    if (!aligned[piece.part]) continue;
    add(piece.start);
    add(piece.end);
  }
  const auto [r_least, r_most] = std::minmax_element(r_m.begin(), r_m.end());
  const auto [z_least, z_most] = std::minmax_element(z_m.begin(), z_m.end());
  const Box extent{*r_least, *r_most, *z_least, *z_most};
  const auto add_box = [&](const Box& box) {
    for (const double r : {box.r0_m, box.r1_m}) {
      if (r > extent.r0_m && r < extent.r1_m) r_m.push_back(r);
    }
    for (const double z : {box.z0_m, box.z1_m}) {
      if (z > extent.z0_m && z < extent.z1_m) z_m.push_back(z);
    }
  };
  for (const Support& support : spindle.supports) add_box(support.face);
  for (const DeformationOutput& output : spindle.deformations) add_box(output.face);
  return {subdivided(without_doubles(r_m), spindle.mesh.element_size_m),
          subdivided(without_doubles(z_m), spindle.mesh.element_size_m)};
}

void add_grid_cells(const TensorGrid& grid, const PartOutline& outline, std::size_t part, SectionMesh& mesh) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> known;
  const auto point = [&](std::size_t i, std::size_t j) {
    const auto [entry, is_new] = known.try_emplace({i, j}, mesh.points.size());
    if (is_new) mesh.points.push_back({grid.r_m[i], grid.z_m[j]});
    return entry->second;
  };
  for (std::size_t j = 0; j + 1 < grid.z_m.size(); ++j) {
    for (std::size_t i = 0; i + 1 < grid.r_m.size(); ++i) {
      const Point centre{0.5 * (grid.r_m[i] + grid.r_m[i + 1]), 0.5 * (grid.z_m[j] + grid.z_m[j + 1])};
      if (!is_inside(outline, centre)) continue;
      mesh.quads.push_back({point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
      mesh.part_of_quad.push_back(part);
    }
  }
}

}  // namespace spindle_twin::fem_offline
