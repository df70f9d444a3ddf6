#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fem_offline/description/face_conditions.hpp"
#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {

/// A straight piece of one part's outline on which one thing happens. A contact or gap appears as two pieces, one
/// per side, with the same `index` and `pair`.
struct BoundaryPiece {
  std::size_t part = 0;
  Point start;  ///< the part lies to the left from start to end
  Point end;
  PieceKind kind = PieceKind::adiabatic;
  std::size_t index = 0;                 ///< into Spindle::contacts, films, gap_films or adiabatics
  int side = 0;                          ///< contact, gap: 0 on part_a, 1 on part_b
  std::size_t pair = 0;                  ///< contact, gap: number shared by the two pieces that face each other
  std::vector<std::size_t> beside = {};  ///< into Spindle::films: those that act besides (Claims::beside)
  std::optional<ArcChord> arc = {};      ///< the side of the outline that holds this piece, if it stands for an arc
};

/// One connected face of a part: outer ring counter-clockwise (r to the right, z up), holes clockwise.
struct OutlineFace {
  Polygon outer;
  std::vector<Polygon> holes;
};

struct PartOutline {
  std::vector<OutlineFace> faces;
  double volume_m3 = 0.0;           ///< of revolution, or per metre of depth; arcs as chords
  std::vector<ArcChord> arcs = {};  ///< sides of the faces that stand for arcs, in the sense of their ring
};

/// The meridian section, exact but for arcs, which are their chords here: outlines of the parts and everything that
/// happens on them.
struct Section {
  std::vector<PartOutline> outlines;  ///< one per part
  std::vector<BoundaryPiece> pieces;
};

/// Unites the shapes of each part and sorts every piece of outline into contact, film, gap, adiabatic or axis (r = 0).
/// Throws rom::InputError naming the parts and the place (mm) for overlapping parts, touching parts with no
/// contact declared, a declared contact that does not touch, a film, gap, adiabatic region or support on no face, an
/// outer face with no film, a face hit by two laws, a key point or deformation face outside its part.
Section build_section(const Spindle& spindle);

/// Volume that a closed ring encloses, Green's theorem: π ∮ r² dz of revolution, ∮ x dy per metre of depth when planar.
/// Positive for a counter-clockwise ring.
double volume_within(const Polygon& ring, Geometry geometry);

/// Whether the film (of any kind) acts on the piece.
bool acts_on(std::size_t film, const BoundaryPiece& piece);

/// Whether a heat's share lies on the piece: a face towards the part that it names, or an exposed face within its box.
/// False of a share in a volume.
bool carries(const Spindle& spindle, const BoundaryPiece& piece, const HeatShare& share);

/// Whether both ends of the piece lie in the closed box, to the snap tolerance of 1e-6 mm. Outlines are split where the
/// face box of a support, a deformation output or a heat begins and ends, so that a piece is either in or out.
bool lies_in(const BoundaryPiece& piece, const Box& box);

}  // namespace spindle_twin::fem_offline
