#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fem_offline/mesh/section.hpp"

/// The steps of build_section. All lengths here are millimetres on a grid of 1e-6 mm, so that equal numbers of a
/// description stay equal.
namespace spindle_twin::fem_offline::section_detail {

constexpr double snap_mm = 1e-6;
/// How far off a face the "outward side" is probed; far below any gap or clearance that a description holds.
constexpr double hair_mm = 1e-4;

struct Vec {
  double r = 0.0;
  double z = 0.0;
};

struct BoxMm {
  double r0, r1, z0, z1;
};

/// Nearest point of the grid.
double snapped(double value_mm);

Vec to_mm(const Point& point);
BoxMm to_mm(const Box& box);
Point to_m(const Vec& point);
bool same(const Vec& a, const Vec& b);
bool contains(const BoxMm& box, const Vec& point);

/// "(r 30, z 28) mm" and "(r 30, z 28) to (r 30, z 45) mm".
std::string printed(const Vec& point);
std::string printed(const Vec& from, const Vec& to);

/// Where an edge is cut. A lasting cut stays although the same thing happens on both of its sides.
struct Cut {
  Vec at;
  bool lasting = false;
};

/// What has a piece to itself; as in BoundaryPiece.
struct Claim {
  PieceKind kind = PieceKind::adiabatic;
  std::size_t index = 0;
  int side = 0;
  bool operator==(const Claim&) const = default;
};

struct Edge {
  std::size_t part = 0;
  Vec start, end;  // the part lies to the left
  std::vector<Cut> cuts;

  double length() const;
  Vec along() const;    // unit vector
  Vec outward() const;  // unit normal
  double position(const Vec& point) const;
  double distance(const Vec& point) const;  // from the edge's line, signed, outward positive
};

struct Piece {
  std::size_t part = 0;
  Vec start, end;
  bool lasting_end = false;  // the cut at `end` must stay
  bool last_of_edge = false;
  std::optional<Claim> claim;
  std::size_t pair = 0;
  std::vector<std::size_t> beside = {};  // as in BoundaryPiece

  Vec hair_outside() const;
};

/// Unites shapes and takes cuts away; throws for a shape that crosses itself and for an empty part.
std::vector<PartOutline> unite_parts(const Spindle& spindle);

/// Throws for the first two parts that overlap, naming both and the place.
void refuse_overlaps(const Spindle& spindle, const std::vector<PartOutline>& outlines);

bool covers(const PartOutline& outline, const Vec& point);

std::vector<Edge> edges_of(const std::vector<PartOutline>& outlines);

/// Cuts every edge where a neighbour, a region or a face box begins or ends; both sides of a contact or gap get the
/// same cuts.
std::vector<Piece> cut_edges(const Spindle& spindle, std::vector<Edge> edges);

/// Gives every piece the one condition that claims it, joins pieces that need no cut between them and numbers the
/// pairs.
std::vector<BoundaryPiece> sort_pieces(const Spindle& spindle, std::vector<Piece> pieces);

/// Throws for a support, key point, deformation output, heat or interference fit that is not where it says it is.
void check_places(const Spindle& spindle, const Section& section);

/// Part of [start, end] inside the closed box as distances from start; empty if shorter than the snap tolerance.
std::optional<std::pair<double, double>> clip(const Vec& start, const Vec& end, const BoxMm& box);

/// The stretch that both of two opposite edges of different parts share, as positions along `a`.
std::optional<std::pair<double, double>> shared_stretch(const Edge& a, const Edge& b);

}  // namespace spindle_twin::fem_offline::section_detail
