#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Two places nearer than this are one; so much may a typed centre miss the middle of both ends.
constexpr double same_corner_mm = 1e-6;
constexpr double centre_error_mm = 1e-3;
constexpr int most_chords = 720;
/// Whatever the tolerance, a quarter circle keeps two chords.
constexpr double largest_step = std::numbers::pi / 4.0;

struct Corner {
  double r_mm = 0.0, z_mm = 0.0;
};

double distance_mm(const Corner& a, const Corner& b) { return std::hypot(b.r_mm - a.r_mm, b.z_mm - a.z_mm); }

double angle_of(const Corner& centre, const Corner& at) {
  return std::atan2(at.z_mm - centre.z_mm, at.r_mm - centre.r_mm);
}

/// Turning angle from a to b seen from the centre, counter-clockwise, in (0, 2 pi).
double turn(const Corner& centre, const Corner& a, const Corner& b) {
  const double angle = angle_of(centre, b) - angle_of(centre, a);
  return angle > 0.0 ? angle : angle + 2.0 * std::numbers::pi;
}

struct Arc {
  Corner from, to, centre;
  bool clockwise = false;
};

Corner corner_from(const TomlTable& table, const std::string& key, Geometry geometry) {
  const auto row_mm = table.numbers(key, 2, coordinate_mm(geometry));
  return {row_mm[0], row_mm[1]};
}

/// Centre of the circle through three points, which lie the other way round if it is clockwise.
Arc through(const TomlTable& table, const Corner& from, const Corner& by, const Corner& to) {
  const double r1 = by.r_mm - from.r_mm, z1 = by.z_mm - from.z_mm;
  const double r2 = to.r_mm - from.r_mm, z2 = to.z_mm - from.z_mm;
  const double cross = r1 * z2 - r2 * z1, square1 = r1 * r1 + z1 * z1, square2 = r2 * r2 + z2 * z2;
  if (std::min(distance_mm(from, by), distance_mm(by, to)) <= same_corner_mm ||
      std::abs(cross) <= 1e-6 * std::sqrt(square1 * square2)) {
    table.fail("through", "must be a point beside the straight line between the arc's two ends");
  }
  const Corner centre{from.r_mm + 0.5 * (z2 * square1 - z1 * square2) / cross,
                      from.z_mm + 0.5 * (r1 * square2 - r2 * square1) / cross};
  return {from, to, centre, cross < 0.0};
}

Arc about(const TomlTable& table, const Corner& from, const Corner& to) {
  const auto row_mm = table.numbers("centre", 2, rom::between(-1e5, 1e5));
  const Arc arc{from, to, {row_mm[0], row_mm[1]}, table.boolean_or("clockwise", false)};
  const double first_mm = distance_mm(arc.centre, from), last_mm = distance_mm(arc.centre, to);
  if (std::abs(first_mm - last_mm) > centre_error_mm || std::min(first_mm, last_mm) <= same_corner_mm) {
    std::ostringstream text;
    text << "must be as far from both ends of the arc, to " << centre_error_mm << " mm; it is " << first_mm
         << " mm from the first and " << last_mm << " mm from the second";
    table.fail("centre", text.str());
  }
  return arc;
}

/// Corners between the ends of the arc. The division hangs on the circle and its ends alone, not on the sense it is run
/// through, so two parts that share an arc get the same chords.
std::vector<Corner> corners_on(const TomlTable& table, const Arc& arc, const MeshSettings& mesh) {
  const bool swapped = std::pair(arc.to.r_mm, arc.to.z_mm) < std::pair(arc.from.r_mm, arc.from.z_mm);
  const Corner &first = swapped ? arc.to : arc.from, &last = swapped ? arc.from : arc.to;
  const bool clockwise = arc.clockwise != swapped;
  const double sweep = clockwise ? -turn(arc.centre, last, first) : turn(arc.centre, first, last);
  const double radius_mm = distance_mm(arc.centre, first), end_radius_mm = distance_mm(arc.centre, last);
  const double sagitta = std::min(1.0, mesh.arc_sagitta_m / metre_per_mm / radius_mm);
  const double half_chord = std::min(1.0, mesh.element_size_m / metre_per_mm / radius_mm);
  const double step = std::min({2.0 * std::acos(1.0 - sagitta), 2.0 * std::asin(half_chord), largest_step});
  const double wanted = std::ceil(std::abs(sweep) / step - 1e-6);
  if (wanted > most_chords) {
    std::ostringstream text;
    text << "this arc would need " << wanted << " chords, at most " << most_chords
         << " are allowed: raise arc_sagitta_mm or element_size_mm of [mesh]";
    table.fail("to", text.str());
  }
  const int chords = std::max(1, static_cast<int>(wanted));
  std::vector<Corner> corners;
  for (int k = 1; k < chords; ++k) {
    const double share = static_cast<double>(k) / chords;
    const double angle = angle_of(arc.centre, first) + share * sweep;
    const double at_mm = radius_mm + share * (end_radius_mm - radius_mm);
    corners.push_back({arc.centre.r_mm + at_mm * std::cos(angle), arc.centre.z_mm + at_mm * std::sin(angle)});
  }
  if (swapped) std::reverse(corners.begin(), corners.end());
  return corners;
}

}  // namespace

Polygon read_polygon(const TomlTable& table, Geometry geometry, const MeshSettings& mesh,
                     std::vector<ArcChord>& arcs_of_part) {
  std::vector<Corner> corners;
  for (const auto& row : table.rows_or_empty("points", 2, coordinate_mm(geometry))) corners.push_back({row[0], row[1]});
  const auto arcs = table.tables_or_empty("arcs");
  if (corners.size() < (arcs.empty() ? 3U : 2U)) {
    table.fail("points", arcs.empty() ? "must hold at least three [r, z]" : "must hold at least two [r, z]");
  }
  std::vector<std::vector<Corner>> before(corners.size());  // chord corners on the side that ends at each corner
  std::vector<bool> is_arc(corners.size(), false);
  std::vector<Corner> centres(corners.size());
  for (const auto& given : arcs) {
    const Corner to = corner_from(given, "to", geometry);
    const auto found = std::find_if(corners.begin(), corners.end(),
                                    [&](const Corner& corner) { return distance_mm(corner, to) <= same_corner_mm; });
    if (found == corners.end()) given.fail("to", "must be one of the points, the one where the arc ends");
    const auto end = static_cast<std::size_t>(found - corners.begin());
    if (is_arc[end]) given.fail("to", "another arc of this polygon ends there already");
    is_arc[end] = true;
    const Corner& from = corners[(end + corners.size() - 1) % corners.size()];
    if (distance_mm(from, *found) <= same_corner_mm) given.fail("to", "the arc begins and ends at the same point");
    const bool has_centre = given.has("centre"), has_through = given.has("through");
    if (has_centre == has_through) given.fail("to", "an arc needs either centre or through");
    const Arc arc =
        has_centre ? about(given, from, *found) : through(given, from, corner_from(given, "through", geometry), *found);
    before[end] = corners_on(given, arc, mesh);
    centres[end] = arc.centre;
  }
  Polygon polygon;
  const auto add = [&](const Corner& corner) {
    if (geometry == Geometry::axisymmetric && corner.r_mm < -same_corner_mm) {
      table.fail("arcs", "an arc crosses the axis: r must stay at least 0");
    }
    polygon.push_back({corner.r_mm * metre_per_mm, corner.z_mm * metre_per_mm});
  };
  const auto to_m = [](const Corner& corner) { return Point{corner.r_mm * metre_per_mm, corner.z_mm * metre_per_mm}; };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    before[i].push_back(corners[i]);
    const Corner* from = &corners[(i + corners.size() - 1) % corners.size()];
    for (const Corner& corner : before[i]) {
      add(corner);
      if (is_arc[i]) arcs_of_part.push_back({to_m(*from), to_m(corner), to_m(centres[i])});
      from = &corner;
    }
  }
  if (polygon.size() < 3) table.fail("points", "must enclose an area");
  return polygon;
}

}  // namespace spindle_twin::fem_offline
