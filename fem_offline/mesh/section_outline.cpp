// GCC sees the box of an empty multi-polygon as uninitialised deep inside Boost; the headers are not ours to mend.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#define BOOST_ALLOW_DEPRECATED_HEADERS
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/multi_polygon.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cmath>

#include "fem_offline/mesh/section_detail.hpp"

namespace spindle_twin::fem_offline::section_detail {
namespace {

namespace bg = boost::geometry;
using BgPoint = bg::model::d2::point_xy<double>;
using BgPolygon = bg::model::polygon<BgPoint, false>;  // outer ring counter-clockwise
using BgMulti = bg::model::multi_polygon<BgPolygon>;

BgPolygon polygon_from(const Polygon& shape, const Spindle& spindle, const Part& part) {
  BgPolygon polygon;
  for (const Point& corner : shape) {
    const Vec at = to_mm(corner);
    bg::append(polygon.outer(), BgPoint(at.r, at.z));
  }
  bg::correct(polygon);
  std::string reason;
  if (!bg::is_valid(polygon, reason)) {
    throw rom::InputError({spindle.file, part.where.line}, "part." + part.name,
                          "the polygon that starts at " + printed(to_mm(shape.front())) + " is not simple: " + reason);
  }
  return polygon;
}

BgMulti united(const std::vector<Polygon>& shapes, const Spindle& spindle, const Part& part) {
  BgMulti sum;
  for (const Polygon& shape : shapes) {
    BgMulti next;
    bg::union_(sum, polygon_from(shape, spindle, part), next);
    sum = std::move(next);
  }
  return sum;
}

/// The ring on the snap grid without doubled points and points within a straight run.
template <typename Ring>
Polygon clean_ring(const Ring& ring) {
  std::vector<Vec> points;
  for (const BgPoint& point : ring) {
    const Vec at{snapped(point.x()), snapped(point.y())};
    if (points.empty() || !same(points.back(), at)) points.push_back(at);
  }
  while (points.size() > 1 && same(points.front(), points.back())) points.pop_back();
  const auto straight = [&](std::size_t i) {
    const Vec& before = points[(i + points.size() - 1) % points.size()];
    const Vec& after = points[(i + 1) % points.size()];
    const double dr = after.r - before.r, dz = after.z - before.z;
    const double offset = (points[i].r - before.r) * dz - (points[i].z - before.z) * dr;
    return std::abs(offset) <= snap_mm * std::hypot(dr, dz);
  };
  for (std::size_t i = 0; i < points.size() && points.size() > 2;) {
    if (straight(i)) {
      points.erase(points.begin() + static_cast<std::ptrdiff_t>(i));
      i = i > 0 ? i - 1 : 0;
    } else {
      ++i;
    }
  }
  Polygon out;
  for (const Vec& at : points) out.push_back(to_m(at));
  return points.size() > 2 ? out : Polygon{};
}

/// The sides of a ring that lie on chords of arcs.
void add_arcs(const Polygon& ring, const std::vector<ArcChord>& chords, std::vector<ArcChord>& arcs) {
  const auto lies_on = [](const ArcChord& chord, const Point& point) {
    const Vec start = to_mm(chord.start), end = to_mm(chord.end), at = to_mm(point);
    const double r = end.r - start.r, z = end.z - start.z, length = std::hypot(r, z);
    const double along = ((at.r - start.r) * r + (at.z - start.z) * z) / length;
    const double aside = ((at.r - start.r) * z - (at.z - start.z) * r) / length;
    return std::abs(aside) <= snap_mm && along >= -snap_mm && along <= length + snap_mm;
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const auto found = std::find_if(chords.begin(), chords.end(),
                                    [&](const ArcChord& chord) { return lies_on(chord, a) && lies_on(chord, b); });
    if (found != chords.end()) arcs.push_back({a, b, found->centre});
  }
}

BgMulti multi_from(const PartOutline& outline) {
  const auto ring_from = [](const Polygon& ring, auto& to) {
    for (const Point& corner : ring) {
      const Vec at = to_mm(corner);
      to.push_back(BgPoint(at.r, at.z));
    }
    to.push_back(to.front());
  };
  BgMulti multi;
  for (const OutlineFace& face : outline.faces) {
    BgPolygon polygon;
    ring_from(face.outer, polygon.outer());
    for (const Polygon& hole : face.holes) {
      polygon.inners().emplace_back();
      ring_from(hole, polygon.inners().back());
    }
    multi.push_back(std::move(polygon));
  }
  return multi;
}

/// Every side is compared with every other, so that many more would take minutes.
void refuse_too_many_corners(const Spindle& spindle) {
  constexpr std::size_t most_corners = 6000;
  std::size_t corners = 0;
  for (const Part& part : spindle.parts) {
    for (const auto* shapes : {&part.shapes, &part.cuts}) {
      for (const Polygon& shape : *shapes) corners += shape.size();
    }
    if (corners <= most_corners) continue;
    throw rom::InputError(part.where, "part." + part.name,
                          "up to this part the description has " + std::to_string(corners) + " corners, at most " +
                              std::to_string(most_corners) + " are allowed: raise arc_sagitta_mm of [mesh]");
  }
}

}  // namespace

// Division by a whole number gives the nearest double of the decimal number, so 30 stays 30.
double snapped(double value_mm) { return std::round(value_mm * 1e6) / 1e6; }

Vec to_mm(const Point& point) { return {snapped(point.r_m * 1e3), snapped(point.z_m * 1e3)}; }

BoxMm to_mm(const Box& box) {
  return {snapped(box.r0_m * 1e3), snapped(box.r1_m * 1e3), snapped(box.z0_m * 1e3), snapped(box.z1_m * 1e3)};
}

std::vector<PartOutline> unite_parts(const Spindle& spindle) {
  refuse_too_many_corners(spindle);
  std::vector<PartOutline> outlines;
  for (const Part& part : spindle.parts) {
    BgMulti area;
    bg::difference(united(part.shapes, spindle, part), united(part.cuts, spindle, part), area);
    PartOutline outline;
    for (const BgPolygon& polygon : area) {
      OutlineFace face;
      face.outer = clean_ring(polygon.outer());
      if (face.outer.empty()) continue;
      outline.volume_m3 += volume_within(face.outer, spindle.geometry);
      for (const auto& inner : polygon.inners()) {
        Polygon hole = clean_ring(inner);
        if (hole.empty()) continue;
        outline.volume_m3 += volume_within(hole, spindle.geometry);
        face.holes.push_back(std::move(hole));
      }
      if (spindle.mesh.curved_arcs) {
        add_arcs(face.outer, part.arcs, outline.arcs);
        for (const Polygon& hole : face.holes) add_arcs(hole, part.arcs, outline.arcs);
      }
      outline.faces.push_back(std::move(face));
    }
    if (outline.faces.empty()) {
      throw rom::InputError(part.where, "part." + part.name, "nothing is left of this part after its cuts");
    }
    outlines.push_back(std::move(outline));
  }
  return outlines;
}

void refuse_overlaps(const Spindle& spindle, const std::vector<PartOutline>& outlines) {
  std::vector<BgMulti> areas;
  for (const auto& outline : outlines) areas.push_back(multi_from(outline));
  for (std::size_t b = 0; b < areas.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      BgMulti common;
      bg::intersection(areas[a], areas[b], common);
      for (const BgPolygon& polygon : common) {
        // A sliver no thicker than the snap tolerance is two faces that touch.
        if (bg::area(polygon) <= 2.0 * snap_mm * bg::perimeter(polygon)) continue;
        bg::model::box<BgPoint> box;
        bg::envelope(polygon, box);
        const Vec low{box.min_corner().x(), box.min_corner().y()}, high{box.max_corner().x(), box.max_corner().y()};
        throw rom::InputError(spindle.parts[b].where, "part." + spindle.parts[b].name,
                              "overlaps part \"" + spindle.parts[a].name + "\" in the area " + printed(low, high));
      }
    }
  }
}

bool covers(const PartOutline& outline, const Vec& point) {
  return bg::distance(BgPoint(point.r, point.z), multi_from(outline)) <= snap_mm;
}

}  // namespace spindle_twin::fem_offline::section_detail
