#include "fem_offline/mesh/rim.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fem_offline/mesh/element_sizes.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Thinner places do not make elements finer than this part of the size asked for: a sharp edge is thin without end.
constexpr double least_share = 0.1;

/// The ring with the ends of the part's pieces put between its corners.
Polygon with_piece_ends(const Polygon& ring, const std::vector<const BoundaryPiece*>& pieces) {
  Polygon result;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    const double length = distance_m(a, b);
    std::vector<std::pair<double, Point>> between;
    for (const BoundaryPiece* piece : pieces) {
      for (const Point& end : {piece->start, piece->end}) {
        const double along_m = ((end.r_m - a.r_m) * (b.r_m - a.r_m) + (end.z_m - a.z_m) * (b.z_m - a.z_m)) / length;
        const double aside_m = ((end.r_m - a.r_m) * (b.z_m - a.z_m) - (end.z_m - a.z_m) * (b.r_m - a.r_m)) / length;
        if (std::abs(aside_m) > same_place_m) continue;
        if (along_m > same_place_m && along_m < length - same_place_m) between.push_back({along_m, end});
      }
    }
    std::sort(between.begin(), between.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    result.push_back(a);
    double last_m = 0.0;
    for (const auto& [along_m, end] : between) {
      if (along_m - last_m > same_place_m) result.push_back(end);
      last_m = along_m;
    }
  }
  return result;
}

/// How far a ray from the middle of a side runs through the material to the next side.
double thickness_m(const Rim& rim, const RimSide& side) {
  const double length = distance_m(side.start, side.end);
  const Point middle{0.5 * (side.start.r_m + side.end.r_m), 0.5 * (side.start.z_m + side.end.z_m)};
  const double inward_r = -(side.end.z_m - side.start.z_m) / length;
  const double inward_z = (side.end.r_m - side.start.r_m) / length;
  double nearest_m = 1e9;
  for (const auto& ring : rim) {
    for (const RimSide& other : ring) {
      const double r = other.end.r_m - other.start.r_m, z = other.end.z_m - other.start.z_m;
      const double to_r = other.start.r_m - middle.r_m, to_z = other.start.z_m - middle.z_m;
      const double cross = inward_r * z - inward_z * r;
      if (std::abs(cross) < 1e-12 * distance_m(other.start, other.end)) continue;
      const double along_ray_m = (to_r * z - to_z * r) / cross;
      const double along_side = (to_r * inward_z - to_z * inward_r) / cross;
      if (along_side < 0.0 || along_side > 1.0 || along_ray_m <= same_place_m) continue;
      nearest_m = std::min(nearest_m, along_ray_m);
    }
  }
  return nearest_m;
}

bool lies_within(const RimSide& side, const BoundaryPiece& piece) {
  const double length = distance_m(piece.start, piece.end);
  const double r = (piece.end.r_m - piece.start.r_m) / length, z = (piece.end.z_m - piece.start.z_m) / length;
  for (const Point& at : {side.start, side.end}) {
    const double along_m = (at.r_m - piece.start.r_m) * r + (at.z_m - piece.start.z_m) * z;
    const double aside_m = (at.r_m - piece.start.r_m) * z - (at.z_m - piece.start.z_m) * r;
    if (std::abs(aside_m) > same_place_m || along_m < -same_place_m || along_m > length + same_place_m) return false;
  }
  return true;
}

}  // namespace

Rim make_rim(const Spindle& spindle, const Section& section, std::size_t part, const OutlineFace& face) {
  std::vector<const BoundaryPiece*> pieces;
  for (const BoundaryPiece& piece : section.pieces) {
    if (piece.part == part) pieces.push_back(&piece);
  }
  const double size_m = size_of(spindle, part);
  Rim rim;
  const auto add = [&](const Polygon& outline) {
    const Polygon ring = with_piece_ends(outline, pieces);
    rim.emplace_back();
    for (std::size_t i = 0; i < ring.size(); ++i) rim.back().push_back({ring[i], ring[(i + 1) % ring.size()], size_m});
  };
  add(face.outer);
  for (const Polygon& hole : face.holes) add(hole);
  for (auto& ring : rim) {
    for (RimSide& side : ring) {
      const auto on = std::find_if(pieces.begin(), pieces.end(), [&](const auto* p) { return lies_within(side, *p); });
      const bool is_contact = on != pieces.end() && (*on)->kind == PieceKind::contact;
      if (is_contact) {
        const Contact& contact = spindle.contacts[(*on)->index];
        side.size_m = std::min(size_of(spindle, contact.part_a), size_of(spindle, contact.part_b));
        if (spindle.mesh.contact_size_m) side.size_m = std::min(side.size_m, *spindle.mesh.contact_size_m);
      }
      // Both sides of a contact keep one division unless more cells across are asked for.
      if (is_contact && spindle.mesh.cells_across == 1) continue;
      const double thin_m = thickness_m(rim, side) / spindle.mesh.cells_across;
      side.size_m = std::min(side.size_m, std::max(thin_m, least_share * size_m));
    }
  }
  return rim;
}

}  // namespace spindle_twin::fem_offline
