#include "fem_offline/mesh/piece_track.hpp"

#include <cmath>
#include <numbers>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {
namespace {

double angle_of(const Point& centre, const Point& at) { return std::atan2(at.z_m - centre.z_m, at.r_m - centre.r_m); }

/// The angle within half a turn either way.
double within_half_turn(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace

Point on_arc(const ArcChord& arc, double share) {
  const double first = angle_of(arc.centre, arc.start);
  const double angle = first + share * within_half_turn(angle_of(arc.centre, arc.end) - first);
  const double radius_m = (1.0 - share) * distance_m(arc.centre, arc.start) + share * distance_m(arc.centre, arc.end);
  return {arc.centre.r_m + radius_m * std::cos(angle), arc.centre.z_m + radius_m * std::sin(angle)};
}

double arc_length_m(const ArcChord& arc) {
  const double sweep = within_half_turn(angle_of(arc.centre, arc.end) - angle_of(arc.centre, arc.start));
  return 0.5 * (distance_m(arc.centre, arc.start) + distance_m(arc.centre, arc.end)) * std::abs(sweep);
}

PieceTrack::PieceTrack(const BoundaryPiece& piece) : arc_(piece.arc), origin_(piece.start) {
  const double chord_m = distance_m(piece.start, piece.end);
  r_ = (piece.end.r_m - piece.start.r_m) / chord_m;
  z_ = (piece.end.z_m - piece.start.z_m) / chord_m;
  end_m_ = chord_m;
  if (!arc_) return;
  first_angle_ = angle_of(arc_->centre, arc_->start);
  sweep_ = within_half_turn(angle_of(arc_->centre, arc_->end) - first_angle_);
  first_radius_m_ = distance_m(arc_->centre, arc_->start);
  last_radius_m_ = distance_m(arc_->centre, arc_->end);
  arc_m_ = arc_length_m(*arc_);
  const double whole_m = distance_m(arc_->start, arc_->end);
  start_m_ = arc_m_ * distance_m(arc_->start, piece.start) / whole_m;
  end_m_ = arc_m_ * distance_m(arc_->start, piece.end) / whole_m;
}

double PieceTrack::share_of(const Point& at) const {
  return within_half_turn(angle_of(arc_->centre, at) - first_angle_) / sweep_;
}

double PieceTrack::along_m(const Point& at) const {
  if (arc_) return share_of(at) * arc_m_ - start_m_;
  return (at.r_m - origin_.r_m) * r_ + (at.z_m - origin_.z_m) * z_;
}

double PieceTrack::aside_m(const Point& at) const {
  if (!arc_) return (at.r_m - origin_.r_m) * z_ - (at.z_m - origin_.z_m) * r_;
  const double share = share_of(at);
  const double outside_m = distance_m(arc_->centre, at) - ((1.0 - share) * first_radius_m_ + share * last_radius_m_);
  return sweep_ > 0.0 ? outside_m : -outside_m;
}

bool PieceTrack::holds(const Point& at) const {
  const double along = along_m(at);
  return std::abs(aside_m(at)) <= same_place_m && along >= -same_place_m && along <= length_m() + same_place_m;
}

Point PieceTrack::outward(const Point& at) const {
  if (!arc_) return {z_, -r_};
  const double sign = (sweep_ > 0.0 ? 1.0 : -1.0) / distance_m(arc_->centre, at);
  return {sign * (at.r_m - arc_->centre.r_m), sign * (at.z_m - arc_->centre.z_m)};
}

}  // namespace spindle_twin::fem_offline
