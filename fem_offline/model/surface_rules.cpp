#include "fem_offline/model/surface_rules.hpp"

#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "fem_offline/mesh/piece_track.hpp"
#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {
namespace {

using Cell = dealii::DoFHandler<2>::active_cell_iterator;
using CellGeometry = dealii::GeometryInfo<2>;

Point point_of(const dealii::Point<2>& p) { return {p[0], p[1]}; }

double length(const Point& a, const Point& b) { return std::hypot(b.r_m - a.r_m, b.z_m - a.z_m); }

/// An element's side on a piece, a parabola through both ends and the middle as the mapping has it.
struct Side {
  Cell cell;
  Point start, end;
  dealii::Point<2> unit_start, unit_end;
  Point middle;

  Point at(double share) const {
    const double bend = 4.0 * share * (1.0 - share);
    return {start.r_m + share * (end.r_m - start.r_m) + bend * (middle.r_m - 0.5 * (start.r_m + end.r_m)),
            start.z_m + share * (end.z_m - start.z_m) + bend * (middle.z_m - 0.5 * (start.z_m + end.z_m))};
  }
  /// Length per share. [m]
  double stretch_m(double share) const {
    const double slope = 4.0 - 8.0 * share;
    return std::hypot(end.r_m - start.r_m + slope * (middle.r_m - 0.5 * (start.r_m + end.r_m)),
                      end.z_m - start.z_m + slope * (middle.z_m - 0.5 * (start.z_m + end.z_m)));
  }
};

Side side_of(const Discretisation<2>& discretisation, const Cell& cell, unsigned face) {
  const unsigned v0 = CellGeometry::face_to_cell_vertices(face, 0), v1 = CellGeometry::face_to_cell_vertices(face, 1);
  Side side{cell,
            point_of(cell->vertex(v0)),
            point_of(cell->vertex(v1)),
            CellGeometry::unit_cell_vertex(v0),
            CellGeometry::unit_cell_vertex(v1),
            {}};
  side.middle = {0.5 * (side.start.r_m + side.end.r_m), 0.5 * (side.start.z_m + side.end.z_m)};
  if (discretisation.mapping.get_degree() > 1) {
    const dealii::Point<2> unit = side.unit_start + 0.5 * (side.unit_end - side.unit_start);
    side.middle = point_of(discretisation.mapping.transform_unit_to_real_cell(cell, unit));
  }
  return side;
}

std::vector<std::vector<Side>> sides_of_pieces(const Discretisation<2>& discretisation, const Spindle& spindle,
                                               const Section& section) {
  std::vector<std::vector<std::size_t>> pieces_of_part(section.outlines.size());
  std::vector<PieceTrack> tracks;
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    pieces_of_part[section.pieces[p].part].push_back(p);
    tracks.emplace_back(section.pieces[p]);
  }

  std::vector<std::vector<Side>> sides(section.pieces.size());
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    for (const unsigned face : cell->face_indices()) {
      if (!cell->at_boundary(face)) continue;
      const Side side = side_of(discretisation, cell, face);
      const auto& candidates = pieces_of_part[cell->material_id()];
      const auto found = std::find_if(candidates.begin(), candidates.end(), [&](std::size_t p) {
        return tracks[p].holds(side.start) && tracks[p].holds(side.end);
      });
      if (found == candidates.end()) {
        throw std::logic_error("the side of part '" + spindle.parts[cell->material_id()].name + "' at (r, z) = (" +
                               std::to_string(1e3 * side.start.r_m) + ", " + std::to_string(1e3 * side.start.z_m) +
                               ") mm lies on no piece of the section");
      }
      sides[*found].push_back(side);
    }
  }
  return sides;
}

Trace trace_in_cell(const Discretisation<2>& discretisation, const Cell& cell, const dealii::Point<2>& unit) {
  std::vector<dealii::types::global_dof_index> dofs(discretisation.element.n_dofs_per_cell());
  cell->get_dof_indices(dofs);
  Trace trace;
  for (unsigned i = 0; i < dofs.size(); ++i) {
    const double value = discretisation.element.shape_value(i, unit);
    if (std::abs(value) < 1e-13) continue;
    trace.dofs.push_back(static_cast<int>(dofs[i]));
    trace.values.push_back(value);
  }
  return trace;
}

Trace trace_on(const Discretisation<2>& discretisation, const Side& side, double share) {
  return trace_in_cell(discretisation, side.cell, side.unit_start + share * (side.unit_end - side.unit_start));
}

/// Where along the piece the side begins and ends, begin < end.
std::pair<double, double> span(const PieceTrack& track, const Side& side) {
  return std::minmax({track.along_m(side.start), track.along_m(side.end)});
}

double extent_m(const PieceTrack& track, const Side& side) {
  const auto [from_m, to_m] = span(track, side);
  return to_m - from_m;
}

const Side* side_at(const PieceTrack& track, const std::vector<Side>& sides, double along_m) {
  for (const Side& side : sides) {
    const auto [from_m, to_m] = span(track, side);
    if (from_m < along_m && along_m < to_m) return &side;
  }
  return nullptr;
}

double share_at(const PieceTrack& track, const Side& side, double along_m) {
  const double from_m = track.along_m(side.start), to_m = track.along_m(side.end);
  return (along_m - from_m) / (to_m - from_m);
}

/// Gauss points on every overlap of a side of A with a side of B: exact for elements that do not match, where points on
/// one side's elements alone would integrate over kinks of the other.
std::vector<PairedPoint> common_refinement(const Discretisation<2>& discretisation, const BoundaryPiece& piece_a,
                                           const std::vector<Side>& sides_a, const std::vector<Side>& sides_b) {
  const PieceTrack track(piece_a);
  std::vector<double> breaks_m;
  for (const auto* sides : {&sides_a, &sides_b}) {
    for (const Side& side : *sides) {
      breaks_m.push_back(track.along_m(side.start));
      breaks_m.push_back(track.along_m(side.end));
    }
  }
  std::sort(breaks_m.begin(), breaks_m.end());
  const dealii::QGauss<1> gauss(discretisation.element.degree + 1);
  std::vector<PairedPoint> points;
  for (std::size_t i = 0; i + 1 < breaks_m.size(); ++i) {
    const double length_m = breaks_m[i + 1] - breaks_m[i];
    if (length_m < same_place_m) continue;
    const double middle_m = breaks_m[i] + 0.5 * length_m;
    const Side* a = side_at(track, sides_a, middle_m);
    const Side* b = side_at(track, sides_b, middle_m);
    if (!a || !b) continue;
    for (unsigned q = 0; q < gauss.size(); ++q) {
      const double along_m = breaks_m[i] + length_m * gauss.point(q)[0];
      const double share_a = share_at(track, *a, along_m), share_b = share_at(track, *b, along_m);
      const double r_m = 0.5 * (a->at(share_a).r_m + b->at(share_b).r_m);
      const double per_along =
          0.5 * (a->stretch_m(share_a) / extent_m(track, *a) + b->stretch_m(share_b) / extent_m(track, *b));
      points.push_back({gauss.weight(q) * length_m * per_along * depth_m(discretisation.geometry, r_m),
                        trace_on(discretisation, *a, share_a), trace_on(discretisation, *b, share_b)});
    }
  }
  return points;
}

std::vector<SurfacePoint> points_on(const Discretisation<2>& discretisation, const std::vector<Side>& sides) {
  const dealii::QGauss<1> gauss(discretisation.element.degree + 1);
  std::vector<SurfacePoint> points;
  for (const Side& side : sides) {
    for (unsigned q = 0; q < gauss.size(); ++q) {
      const double share = gauss.point(q)[0];
      const Point at = side.at(share);
      const double weight_m2 = gauss.weight(q) * side.stretch_m(share) * depth_m(discretisation.geometry, at.r_m);
      points.push_back({at, weight_m2, trace_on(discretisation, side, share)});
    }
  }
  return points;
}

double least_length(const std::vector<Side>& sides) {
  double least_m = std::numeric_limits<double>::max();
  for (const Side& side : sides) least_m = std::min(least_m, length(side.start, side.end));
  return least_m;
}

}  // namespace

SurfaceRules make_surface_rules(const Discretisation<2>& discretisation, const Spindle& spindle,
                                const Section& section) {
  const auto sides = sides_of_pieces(discretisation, spindle, section);
  SurfaceRules rules;
  for (const auto& on_piece : sides) rules.pieces.push_back(points_on(discretisation, on_piece));
  for (std::size_t a = 0; a < section.pieces.size(); ++a) {
    const BoundaryPiece& piece_a = section.pieces[a];
    const bool is_paired = piece_a.kind == PieceKind::contact || piece_a.kind == PieceKind::gap;
    if (!is_paired || piece_a.side != 0) continue;
    for (std::size_t b = 0; b < section.pieces.size(); ++b) {
      const BoundaryPiece& piece_b = section.pieces[b];
      if (piece_b.kind != piece_a.kind || piece_b.side != 1 || piece_b.pair != piece_a.pair) continue;
      rules.pairs.push_back({piece_a.kind, piece_a.index, piece_a.part, piece_b.part,
                             std::min(least_length(sides[a]), least_length(sides[b])),
                             common_refinement(discretisation, piece_a, sides[a], sides[b])});
    }
  }
  return rules;
}

Trace trace_at(const Discretisation<2>& discretisation, int part, const Point& at) {
  const dealii::Point<2> point(at.r_m, at.z_m);
  double least_distance = std::numeric_limits<double>::max();
  Cell nearest;
  dealii::Point<2> nearest_unit;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    if (static_cast<int>(cell->material_id()) != part || cell->center().distance(point) > cell->diameter()) continue;
    try {
      const dealii::Point<2> unit = discretisation.mapping.transform_real_to_unit_cell(cell, point);
      const double distance = CellGeometry::distance_to_unit_cell(unit);
      if (distance >= least_distance) continue;
      least_distance = distance;
      nearest = cell;
      nearest_unit = CellGeometry::project_to_unit_cell(unit);
    } catch (const dealii::Mapping<2>::ExcTransformationFailed&) {
      continue;  // far outside this cell
    }
  }
  // Between a hollow arc and its chord there is no material, but the section counts the place as the part's.
  const double largest_distance = discretisation.mapping.get_degree() > 1 ? 0.1 : 1e-3;
  if (least_distance > largest_distance) {
    throw std::logic_error("no element of part " + std::to_string(part) + " at (r, z) = (" +
                           std::to_string(1e3 * at.r_m) + ", " + std::to_string(1e3 * at.z_m) + ") mm");
  }
  return trace_in_cell(discretisation, nearest, nearest_unit);
}

}  // namespace spindle_twin::fem_offline
