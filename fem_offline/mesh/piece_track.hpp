#pragma once

#include "fem_offline/mesh/section.hpp"

namespace spindle_twin::fem_offline {

/// The point of the arc at a share of its angle; share 0 is the start, 1 the end. Where both ends are not equally far
/// from the centre the radius changes evenly.
Point on_arc(const ArcChord& arc, double share);

/// Length along an arc. [m]
double arc_length_m(const ArcChord& arc);

/// Coordinates along a piece of outline, a straight line or the arc that it stands for. A point of a chord belongs to
/// the point of its arc at the same share of length and angle.
class PieceTrack {
 public:
  explicit PieceTrack(const BoundaryPiece& piece);

  double length_m() const { return end_m_ - start_m_; }
  /// From the piece's start. [m]
  double along_m(const Point& at) const;
  /// To the right of the way from start to end: out of the part. [m]
  double aside_m(const Point& at) const;
  /// Whether the point lies on the piece, to `same_place_m`.
  bool holds(const Point& at) const;
  /// Unit normal out of the part at a point of the piece.
  Point outward(const Point& at) const;

 private:
  double share_of(const Point& at) const;  // of the arc's angle

  std::optional<ArcChord> arc_;
  Point origin_;
  double r_ = 0.0, z_ = 0.0;  // unit direction of a straight piece
  double start_m_ = 0.0, end_m_ = 0.0, arc_m_ = 0.0;
  double first_angle_ = 0.0, sweep_ = 0.0, first_radius_m_ = 0.0, last_radius_m_ = 0.0;
};

}  // namespace spindle_twin::fem_offline
