#include "fem_offline/mesh/bend_sides.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "fem_offline/mesh/piece_track.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Share of the chord's length at which the point lies on it.
std::optional<double> share_on(const ArcChord& chord, const Point& at) {
  const double r = chord.end.r_m - chord.start.r_m, z = chord.end.z_m - chord.start.z_m, length_m = std::hypot(r, z);
  const double dr = at.r_m - chord.start.r_m, dz = at.z_m - chord.start.z_m;
  const double along_m = (dr * r + dz * z) / length_m;
  if (std::abs(dr * z - dz * r) > same_place_m * length_m) return std::nullopt;
  if (along_m < -same_place_m || along_m > length_m + same_place_m) return std::nullopt;
  return along_m / length_m;
}

}  // namespace

void bend_sides(const PartOutline& outline, std::size_t first_quad, std::size_t last_quad, SectionMesh& mesh) {
  if (outline.arcs.empty()) return;
  std::map<std::pair<std::size_t, std::size_t>, int> uses;
  for (std::size_t q = first_quad; q < last_quad; ++q) {
    for (std::size_t k = 0; k < 4; ++k) ++uses[std::minmax(mesh.quads[q][k], mesh.quads[q][(k + 1) % 4])];
  }
  std::map<std::size_t, Point> moved;
  for (const auto& [side, count] : uses) {
    if (count != 1) continue;
    const auto [a, b] = side;
    for (const ArcChord& chord : outline.arcs) {
      const auto share_a = share_on(chord, mesh.points[a]), share_b = share_on(chord, mesh.points[b]);
      if (!share_a || !share_b) continue;
      mesh.bent_sides.push_back({a, b, chord.centre});
      for (const auto& [point, share] : {std::pair{a, *share_a}, std::pair{b, *share_b}}) {
        const double length_m = std::hypot(chord.end.r_m - chord.start.r_m, chord.end.z_m - chord.start.z_m);
        const bool is_end = std::min(share, 1.0 - share) * length_m < same_place_m;
        if (!is_end) moved[point] = on_arc(chord, share);
      }
      break;
    }
  }
  for (const auto& [point, at] : moved) mesh.points[point] = at;
}

}  // namespace spindle_twin::fem_offline
