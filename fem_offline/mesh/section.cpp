#include "fem_offline/mesh/section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem_offline/mesh/piece_track.hpp"
#include "fem_offline/mesh/section_detail.hpp"

namespace spindle_twin::fem_offline {

namespace section_detail {
namespace {

bool any_piece_in(const Section& section, std::size_t part, const Box& face, bool exposed_only) {
  return std::any_of(section.pieces.begin(), section.pieces.end(), [&](const BoundaryPiece& piece) {
    const bool exposed =
        piece.kind == PieceKind::film || piece.kind == PieceKind::adiabatic || piece.kind == PieceKind::gap;
    return piece.part == part && lies_in(piece, face) && (exposed || !exposed_only);
  });
}

bool any_piece_begins_at(const Section& section, std::size_t part, const Box& point) {
  return std::any_of(section.pieces.begin(), section.pieces.end(), [&](const BoundaryPiece& piece) {
    return piece.part == part && contains(to_mm(point), to_mm(piece.start));
  });
}

std::string face_text(const Box& face) {
  const BoxMm box = to_mm(face);
  return printed({box.r0, box.z0}, {box.r1, box.z1});
}

void check_heats(const Spindle& spindle, const Section& section) {
  for (const HeatSource& heat : spindle.heats) {
    for (const HeatShare& share : heat.shares) {
      const std::string& part = spindle.parts[share.part].name;
      if (share.on_face && !any_piece_in(section, share.part, *share.on_face, true)) {
        throw rom::InputError(heat.where, "heat." + heat.name,
                              "part \"" + part + "\" has no exposed face in " + face_text(*share.on_face));
      }
      if (!share.on_contact_with) continue;
      const bool declared = std::any_of(spindle.contacts.begin(), spindle.contacts.end(), [&](const Contact& contact) {
        return std::minmax(contact.part_a, contact.part_b) == std::minmax(share.part, *share.on_contact_with);
      });
      if (!declared) {
        throw rom::InputError(heat.where, "heat." + heat.name,
                              "parts \"" + part + "\" and \"" + spindle.parts[*share.on_contact_with].name +
                                  "\" have no contact on which it could act");
      }
    }
  }
}

/// Whether the point lies between the chord of an arc that bulges out of the part and the arc, on it included.
bool lies_under_arc(const ArcChord& arc, const Point& at) {
  const PieceTrack chord({0, arc.start, arc.end}), bulge({0, arc.start, arc.end, PieceKind::axis, 0, 0, 0, {}, arc});
  const double along_m = chord.along_m(at);
  return along_m >= 0.0 && along_m <= chord.length_m() && chord.aside_m(at) >= 0.0 &&
         bulge.aside_m(at) <= snap_mm * 1e-3;
}

/// The inner body of a fit touches the outer one on a cylinder of the fit's radius.
void check_fits(const Spindle& spindle, const Section& section) {
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const Contact& contact = spindle.contacts[i];
    if (!contact.fit) continue;
    const double radius_mm = snapped(contact.fit->fit_radius_m * 1e3);
    const bool found = std::any_of(section.pieces.begin(), section.pieces.end(), [&](const BoundaryPiece& piece) {
      const Vec start = to_mm(piece.start), end = to_mm(piece.end);
      return piece.kind == PieceKind::contact && piece.index == i && piece.side == 0 && end.z > start.z &&
             std::abs(start.r - radius_mm) <= snap_mm && std::abs(end.r - radius_mm) <= snap_mm;
    });
    if (found) continue;
    const std::string &inner = spindle.parts[contact.part_a].name, &outer = spindle.parts[contact.part_b].name;
    throw rom::InputError(contact.where, "contact." + inner + "-" + outer + ".interference_fit",
                          "part \"" + inner + "\" does not sit in part \"" + outer +
                              "\" at fit_radius_mm; the inner part is named first in \"between\"");
  }
}

}  // namespace

void check_places(const Spindle& spindle, const Section& section) {
  for (const Support& support : spindle.supports) {
    if (support.is_point() ? any_piece_begins_at(section, support.part, support.face)
                           : any_piece_in(section, support.part, support.face, false)) {
      continue;
    }
    if (support.is_point()) {
      throw rom::InputError(support.where, "support",
                            "the outline of part \"" + spindle.parts[support.part].name + "\" does not pass " +
                                printed(Vec{to_mm(support.face).r0, to_mm(support.face).z0}) + " mm");
    }
    throw rom::InputError(
        support.where, "support",
        "part \"" + spindle.parts[support.part].name + "\" has no face in " + face_text(support.face));
  }
  const auto check_point = [&](const rom::SourceLine& where, const std::string& field, std::size_t part,
                               const Point& at) {
    const auto& arcs = section.outlines[part].arcs;
    if (covers(section.outlines[part], to_mm(at)) ||
        std::any_of(arcs.begin(), arcs.end(), [&](const ArcChord& arc) { return lies_under_arc(arc, at); })) {
      return;
    }
    throw rom::InputError(where, field,
                          printed(to_mm(at)) + " mm lies outside part \"" + spindle.parts[part].name + "\"");
  };
  for (const StressProbe& probe : spindle.stress_probes) {
    check_point(probe.where, "stress_probe." + probe.name, probe.part, probe.at);
  }
  for (const DeformationOutput& output : spindle.deformations) {
    if (output.at) {
      check_point(output.where, "deformation." + output.name, output.part, *output.at);
      continue;
    }
    if (any_piece_in(section, output.part, output.face, false)) continue;
    throw rom::InputError(output.where, "deformation." + output.name,
                          "part \"" + spindle.parts[output.part].name + "\" has no face in " + face_text(output.face));
  }
  for (const KeyPoint& point : spindle.key_points) {
    check_point(point.where, "key_point." + point.name, point.part, point.at);
  }
  check_heats(spindle, section);
  check_fits(spindle, section);
}

}  // namespace section_detail

namespace {

/// The arc whose chord holds the piece.
std::optional<ArcChord> arc_of(const std::vector<ArcChord>& arcs, const BoundaryPiece& piece) {
  using section_detail::to_mm;
  const auto holds = [](const ArcChord& chord, const Point& point) {
    const auto start = to_mm(chord.start), end = to_mm(chord.end), at = to_mm(point);
    const double r = end.r - start.r, z = end.z - start.z, length = std::hypot(r, z);
    const double along = ((at.r - start.r) * r + (at.z - start.z) * z) / length;
    const double aside = ((at.r - start.r) * z - (at.z - start.z) * r) / length;
    // The cuts of a slanted side lie on the grid, and so a rounding beside it.
    return std::abs(aside) <= 2.0 * section_detail::snap_mm && along >= -2.0 * section_detail::snap_mm &&
           along <= length + 2.0 * section_detail::snap_mm;
  };
  for (const ArcChord& chord : arcs) {
    if (holds(chord, piece.start) && holds(chord, piece.end)) return chord;
  }
  return std::nullopt;
}

}  // namespace

Section build_section(const Spindle& spindle) {
  Section section;
  section.outlines = section_detail::unite_parts(spindle);
  section_detail::refuse_overlaps(spindle, section.outlines);
  section.pieces = section_detail::sort_pieces(
      spindle, section_detail::cut_edges(spindle, section_detail::edges_of(section.outlines)));
  for (BoundaryPiece& piece : section.pieces) piece.arc = arc_of(section.outlines[piece.part].arcs, piece);
  section_detail::check_places(spindle, section);
  return section;
}

double volume_within(const Polygon& ring, Geometry geometry) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    const double mean = geometry == Geometry::planar
                            ? 0.5 * (a.r_m + b.r_m)
                            : std::numbers::pi / 3.0 * (a.r_m * a.r_m + a.r_m * b.r_m + b.r_m * b.r_m);
    sum += (b.z_m - a.z_m) * mean;
  }
  return sum;
}

bool acts_on(std::size_t film, const BoundaryPiece& piece) {
  return (piece.kind == PieceKind::film && piece.index == film) ||
         std::find(piece.beside.begin(), piece.beside.end(), film) != piece.beside.end();
}

bool carries(const Spindle& spindle, const BoundaryPiece& piece, const HeatShare& share) {
  if (piece.part != share.part) return false;
  if (share.on_contact_with) {
    if (piece.kind != PieceKind::contact) return false;
    const Contact& contact = spindle.contacts[piece.index];
    return (piece.side == 0 ? contact.part_b : contact.part_a) == *share.on_contact_with;
  }
  const bool is_exposed = piece.kind != PieceKind::contact && piece.kind != PieceKind::axis;
  return share.on_face && is_exposed && lies_in(piece, *share.on_face);
}

bool lies_in(const BoundaryPiece& piece, const Box& box) {
  const auto box_mm = section_detail::to_mm(box);
  return section_detail::contains(box_mm, section_detail::to_mm(piece.start)) &&
         section_detail::contains(box_mm, section_detail::to_mm(piece.end));
}

}  // namespace spindle_twin::fem_offline
