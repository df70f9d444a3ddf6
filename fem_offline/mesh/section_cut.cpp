#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <utility>

#include "fem_offline/mesh/section_detail.hpp"

namespace spindle_twin::fem_offline::section_detail {
namespace {

using Stretch = std::optional<std::pair<double, double>>;

bool axis_parallel(const Edge& edge) {
  return std::abs(edge.start.r - edge.end.r) <= snap_mm || std::abs(edge.start.z - edge.end.z) <= snap_mm;
}

Vec point_at(const Edge& edge, double position) {
  const Vec along = edge.along();
  return {snapped(edge.start.r + along.r * position), snapped(edge.start.z + along.z * position)};
}

void add_cut(Edge& edge, const Vec& at, bool lasting) {
  const double position = edge.position(at);
  if (position <= snap_mm || position >= edge.length() - snap_mm) return;
  for (Cut& cut : edge.cuts) {
    if (std::abs(edge.position(cut.at) - position) <= snap_mm) {
      cut.lasting = cut.lasting || lasting;
      return;
    }
  }
  edge.cuts.push_back({at, lasting});
}

void add_cuts(Edge& edge, const Stretch& stretch, bool lasting) {
  if (!stretch) return;
  add_cut(edge, point_at(edge, stretch->first), lasting);
  add_cut(edge, point_at(edge, stretch->second), lasting);
}

/// Where the void beside the edge lies in the region. An edge along the region's border is judged a hair outside, where
/// the void is; a slanted edge crosses the border at one point, which is exact on the edge itself.
void cut_at_region(Edge& edge, const BoxMm& region) {
  Vec start = edge.start, end = edge.end;
  if (axis_parallel(edge)) {
    const Vec out = edge.outward();
    start = {start.r + hair_mm * out.r, start.z + hair_mm * out.z};
    end = {end.r + hair_mm * out.r, end.z + hair_mm * out.z};
  }
  add_cuts(edge, clip(start, end, region), false);
}

bool opposite(const Edge& a, const Edge& b) {
  const Vec u = a.along(), v = b.along();
  return u.r * v.r + u.z * v.z < 0.0;
}

/// Two axis-parallel edges that look at each other across the gap region: the positions along `a` that face `b`.
Stretch facing_stretch(const Edge& a, const Edge& b, const BoxMm& region) {
  if (!axis_parallel(a) || !axis_parallel(b) || !opposite(a, b)) return std::nullopt;
  const Vec u = a.along(), v = b.along();
  if (std::abs(u.r * v.z - u.z * v.r) > 1e-9 || a.distance(b.start) <= snap_mm) return std::nullopt;
  const auto in_region = [&](const Edge& edge) {
    const Vec out = edge.outward();
    return clip({edge.start.r + hair_mm * out.r, edge.start.z + hair_mm * out.z},
                {edge.end.r + hair_mm * out.r, edge.end.z + hair_mm * out.z}, region);
  };
  const Stretch on_a = in_region(a), on_b = in_region(b);
  if (!on_a || !on_b) return std::nullopt;
  const double b_low = a.position(point_at(b, on_b->second)), b_high = a.position(point_at(b, on_b->first));
  const double low = std::max(on_a->first, b_low), high = std::min(on_a->second, b_high);
  if (high - low <= snap_mm) return std::nullopt;
  return std::make_pair(low, high);
}

/// Carries the cuts of each edge within the stretch to the other.
void exchange_cuts(Edge& a, Edge& b, const std::pair<double, double>& stretch,
                   const std::function<Vec(const Edge&, const Vec&)>& onto) {
  const auto within = [&](const Vec& at) {
    const double position = a.position(at);
    return position >= stretch.first - snap_mm && position <= stretch.second + snap_mm;
  };
  const std::vector<Cut> of_a = a.cuts, of_b = b.cuts;
  for (const Cut& cut : of_b) {
    if (within(cut.at)) add_cut(a, onto(a, cut.at), cut.lasting);
  }
  for (const Cut& cut : of_a) {
    if (within(cut.at)) add_cut(b, onto(b, cut.at), cut.lasting);
  }
}

void cut_at_gap(const FaceItem& gap, std::vector<Edge>& edges) {
  const BoxMm region = to_mm(gap.regions.front());
  for (Edge& a : edges) {
    if (a.part != gap.parts[0]) continue;
    for (Edge& b : edges) {
      if (b.part != gap.parts[1]) continue;
      const Stretch stretch = facing_stretch(a, b, region);
      if (!stretch) continue;
      const auto across = [](const Edge& edge, const Vec& at) { return point_at(edge, edge.position(at)); };
      for (const double position : {stretch->first, stretch->second}) {
        add_cut(a, point_at(a, position), true);
        add_cut(b, across(b, point_at(a, position)), true);
      }
      exchange_cuts(a, b, *stretch, across);
    }
  }
}

void cut_at_neighbours(std::vector<Edge>& edges) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      Edge &a = edges[i], &b = edges[j];
      const Stretch stretch = shared_stretch(a, b);
      if (!stretch) continue;
      for (const Vec& end : {b.start, b.end}) add_cut(a, end, true);
      for (const Vec& end : {a.start, a.end}) add_cut(b, end, true);
    }
  }
  // Only after every edge has its own cuts can the two sides of a contact be made equal.
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      if (const Stretch stretch = shared_stretch(edges[i], edges[j])) {
        exchange_cuts(edges[i], edges[j], *stretch, [](const Edge&, const Vec& at) { return at; });
      }
    }
  }
}

void cut_at_box(Edge& edge, std::size_t part, const Box& box) {
  if (part == edge.part) add_cuts(edge, clip(edge.start, edge.end, to_mm(box)), true);
}

/// Where the faces of one condition begin and end; what lies between two parts is cut for both together.
void cut_at_item(Edge& edge, const FaceItem& item) {
  const Finds finds = item.condition->finds;
  for (const Box& region : item.regions) {
    if (finds == Finds::faces_towards_voids) cut_at_region(edge, to_mm(region));
    if (finds == Finds::faces_in_a_box) cut_at_box(edge, item.parts.front(), region);
  }
}

/// Where supports and the faces of deformation outputs begin and end.
void cut_at_mechanics(Edge& edge, const Spindle& spindle) {
  for (const Support& support : spindle.supports) {
    if (!support.is_point()) {
      cut_at_box(edge, support.part, support.face);
      continue;
    }
    const BoxMm box = to_mm(support.face);
    const Vec point{box.r0, box.z0};
    if (support.part == edge.part && std::abs(edge.distance(point)) <= 2.0 * snap_mm) add_cut(edge, point, true);
  }
  for (const DeformationOutput& output : spindle.deformations) {
    if (!output.at) cut_at_box(edge, output.part, output.face);
  }
}

}  // namespace

Point to_m(const Vec& point) { return {point.r * 1e-3, point.z * 1e-3}; }

bool same(const Vec& a, const Vec& b) {
  return std::abs(a.r - b.r) <= 2.0 * snap_mm && std::abs(a.z - b.z) <= 2.0 * snap_mm;
}

bool contains(const BoxMm& box, const Vec& point) {
  return point.r >= box.r0 - snap_mm && point.r <= box.r1 + snap_mm && point.z >= box.z0 - snap_mm &&
         point.z <= box.z1 + snap_mm;
}

std::string printed(const Vec& point) {
  std::ostringstream text;
  text.precision(9);
  text << "(r " << point.r << ", z " << point.z << ")";
  return text.str();
}

std::string printed(const Vec& from, const Vec& to) { return printed(from) + " to " + printed(to) + " mm"; }

double Edge::length() const { return std::hypot(end.r - start.r, end.z - start.z); }

Vec Edge::along() const {
  const double of = length();
  return {(end.r - start.r) / of, (end.z - start.z) / of};
}

Vec Edge::outward() const {
  const Vec u = along();
  return {u.z, -u.r};
}

double Edge::position(const Vec& point) const {
  const Vec u = along();
  return (point.r - start.r) * u.r + (point.z - start.z) * u.z;
}

double Edge::distance(const Vec& point) const {
  const Vec n = outward();
  return (point.r - start.r) * n.r + (point.z - start.z) * n.z;
}

std::optional<std::pair<double, double>> clip(const Vec& start, const Vec& end, const BoxMm& box) {
  const double length = std::hypot(end.r - start.r, end.z - start.z);
  double low = 0.0, high = length;
  const auto narrow = [&](double from, double slope, double min, double max) {
    if (std::abs(slope) < 1e-12) {
      if (from < min - snap_mm || from > max + snap_mm) high = -1.0;
      return;
    }
    const double first = (min - from) / slope, second = (max - from) / slope;
    low = std::max(low, std::min(first, second));
    high = std::min(high, std::max(first, second));
  };
  narrow(start.r, (end.r - start.r) / length, box.r0, box.r1);
  narrow(start.z, (end.z - start.z) / length, box.z0, box.z1);
  if (high - low <= snap_mm) return std::nullopt;
  return std::make_pair(low, high);
}

std::optional<std::pair<double, double>> shared_stretch(const Edge& a, const Edge& b) {
  if (a.part == b.part || !opposite(a, b)) return std::nullopt;
  // The shorter edge must lie on the line of the longer: the offset of a long edge's far end means nothing.
  const bool a_is_longer = a.length() >= b.length();
  const Edge& line = a_is_longer ? a : b;
  const Edge& other = a_is_longer ? b : a;
  if (std::abs(line.distance(other.start)) > 2.0 * snap_mm || std::abs(line.distance(other.end)) > 2.0 * snap_mm) {
    return std::nullopt;
  }
  const double low = std::max(0.0, a.position(b.end)), high = std::min(a.length(), a.position(b.start));
  if (high - low <= 2.0 * snap_mm) return std::nullopt;
  return std::make_pair(low, high);
}

std::vector<Edge> edges_of(const std::vector<PartOutline>& outlines) {
  std::vector<Edge> edges;
  const auto add_ring = [&](std::size_t part, const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      edges.push_back({part, to_mm(ring[i]), to_mm(ring[(i + 1) % ring.size()]), {}});
    }
  };
  for (std::size_t part = 0; part < outlines.size(); ++part) {
    for (const OutlineFace& face : outlines[part].faces) {
      add_ring(part, face.outer);
      for (const Polygon& hole : face.holes) add_ring(part, hole);
    }
  }
  return edges;
}

std::vector<Piece> cut_edges(const Spindle& spindle, std::vector<Edge> edges) {
  const std::vector<FaceItem> items = face_items(spindle);
  for (Edge& edge : edges) {
    for (const FaceItem& item : items) cut_at_item(edge, item);
    cut_at_mechanics(edge, spindle);
  }
  for (const FaceItem& item : items) {
    if (item.condition->finds == Finds::walls_of_a_gap) cut_at_gap(item, edges);
  }
  cut_at_neighbours(edges);

  std::vector<Piece> pieces;
  for (Edge& edge : edges) {
    std::sort(edge.cuts.begin(), edge.cuts.end(),
              [&](const Cut& a, const Cut& b) { return edge.position(a.at) < edge.position(b.at); });
    Vec from = edge.start;
    for (const Cut& cut : edge.cuts) {
      pieces.push_back({edge.part, from, cut.at, cut.lasting, false, std::nullopt, 0});
      from = cut.at;
    }
    pieces.push_back({edge.part, from, edge.end, true, true, std::nullopt, 0});
  }
  return pieces;
}

Vec Piece::hair_outside() const {
  const Edge edge{part, start, end, {}};
  const Vec out = edge.outward();
  return {0.5 * (start.r + end.r) + hair_mm * out.r, 0.5 * (start.z + end.z) + hair_mm * out.z};
}

}  // namespace spindle_twin::fem_offline::section_detail
