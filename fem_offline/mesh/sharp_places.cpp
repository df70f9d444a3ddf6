#include "fem_offline/mesh/sharp_places.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

namespace spindle_twin::fem_offline {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
/// Flatter corners than this have an order near that of the elements.
constexpr double least_reentrant = 200.0 * degree;
/// A whole turn of material is no corner.
constexpr double whole_turn = 359.0 * degree;
/// A held face is a plane of symmetry, behind which the corner is there twice.
constexpr double least_at_held_end = 0.5 * least_reentrant;

/// Material around a point.
struct Corner {
  Point at;
  double angle = 0.0;                           // of all parts
  std::map<std::size_t, double> angle_of_part;  // by part
};

double angle_between(const Point& before, const Point& at, const Point& after) {
  const double r1 = after.r_m - at.r_m, z1 = after.z_m - at.z_m;
  const double r2 = before.r_m - at.r_m, z2 = before.z_m - at.z_m;
  return std::atan2(r1 * z2 - z1 * r2, r1 * r2 + z1 * z2);
}

std::map<PlaceKey, Corner> corners_of(const SectionMesh& mesh) {
  std::map<PlaceKey, Corner> corners;
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    const auto& quad = mesh.quads[q];
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& at = mesh.points[quad[k]];
      const double angle = angle_between(mesh.points[quad[(k + 3) % 4]], at, mesh.points[quad[(k + 1) % 4]]);
      Corner& corner = corners[place_key(at)];
      corner.at = at;
      corner.angle += angle;
      corner.angle_of_part[mesh.part_of_quad[q]] += angle;
    }
  }
  return corners;
}

bool is_reentrant(double angle) { return angle > least_reentrant && angle < whole_turn; }

/// The points where two sides of one part meet that stand for arcs.
std::set<PlaceKey> joints_of_arcs(const Section& section) {
  std::set<PlaceKey> joints;
  for (const PartOutline& outline : section.outlines) {
    std::set<PlaceKey> ends;
    for (const ArcChord& arc : outline.arcs) {
      for (const Point& end : {arc.start, arc.end}) {
        if (!ends.insert(place_key(end)).second) joints.insert(place_key(end));
      }
    }
  }
  return joints;
}

bool is_held(const Spindle& spindle, const BoundaryPiece& piece) {
  if (piece.kind == PieceKind::film && spindle.films[piece.index].condition->assembles == Assembles::held_temperature) {
    return true;
  }
  for (const Support& support : spindle.supports) {
    const bool is_fixed = support.hold_r == Hold::fixed || support.hold_z == Hold::fixed;
    if (is_fixed && support.part == piece.part && lies_in(piece, support.face)) return true;
  }
  return false;
}

/// How often a point is the end of a held piece: once where holding ends.
std::map<PlaceKey, int> ends_of_held(const Spindle& spindle, const Section& section) {
  std::map<PlaceKey, int> ends;
  for (const BoundaryPiece& piece : section.pieces) {
    if (!is_held(spindle, piece)) continue;
    for (const Point& end : {piece.start, piece.end}) ++ends[place_key(end)];
  }
  return ends;
}

}  // namespace

std::vector<Point> sharp_places(const Spindle& spindle, const Section& section, const SectionMesh& mesh) {
  const std::set<PlaceKey> arc_joints = joints_of_arcs(section);
  const std::map<PlaceKey, int> held_ends = ends_of_held(spindle, section);
  std::vector<Point> places;
  for (const auto& [key, corner] : corners_of(mesh)) {
    if (arc_joints.contains(key)) continue;
    bool is_sharp = is_reentrant(corner.angle);
    for (const auto& [part, angle] : corner.angle_of_part) is_sharp = is_sharp || is_reentrant(angle);
    const auto held = held_ends.find(key);
    if (held != held_ends.end() && held->second == 1) is_sharp = is_sharp || corner.angle > least_at_held_end;
    if (is_sharp) places.push_back(corner.at);
  }
  return places;
}

}  // namespace spindle_twin::fem_offline
