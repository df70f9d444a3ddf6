#include "fem_offline/mesh/section.hpp"

#include <algorithm>
#include <cmath>

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
    if (any_piece_in(section, support.part, support.face, false)) continue;
    throw rom::InputError(
        support.where, "support",
        "part \"" + spindle.parts[support.part].name + "\" has no face in " + face_text(support.face));
  }
  for (const DeformationOutput& output : spindle.deformations) {
    if (any_piece_in(section, output.part, output.face, false)) continue;
    throw rom::InputError(output.where, "deformation." + output.name,
                          "part \"" + spindle.parts[output.part].name + "\" has no face in " + face_text(output.face));
  }
  for (const KeyPoint& point : spindle.key_points) {
    if (covers(section.outlines[point.part], to_mm(point.at))) continue;
    throw rom::InputError(
        point.where, "key_point." + point.name,
        printed(to_mm(point.at)) + " mm lies outside part \"" + spindle.parts[point.part].name + "\"");
  }
  check_heats(spindle, section);
  check_fits(spindle, section);
}

}  // namespace section_detail

Section build_section(const Spindle& spindle) {
  Section section;
  section.outlines = section_detail::unite_parts(spindle);
  section_detail::refuse_overlaps(spindle, section.outlines);
  section.pieces = section_detail::sort_pieces(
      spindle, section_detail::cut_edges(spindle, section_detail::edges_of(section.outlines)));
  section_detail::check_places(spindle, section);
  return section;
}

bool lies_in(const BoundaryPiece& piece, const Box& box) {
  const auto box_mm = section_detail::to_mm(box);
  return section_detail::contains(box_mm, section_detail::to_mm(piece.start)) &&
         section_detail::contains(box_mm, section_detail::to_mm(piece.end));
}

}  // namespace spindle_twin::fem_offline
