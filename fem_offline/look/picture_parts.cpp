#include <algorithm>
#include <cmath>
#include <limits>

#include "fem_offline/look/picture_frame.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr Colour contact_colour{0.10, 0.10, 0.12, 1.0};
constexpr Colour fit_colour{0.85, 0.05, 0.10, 1.0};
constexpr Colour gap_colour{0.95, 0.55, 0.00, 1.0};
constexpr Colour adiabatic_colour{0.55, 0.55, 0.58, 1.0};
constexpr Colour heat_colour{0.86, 0.25, 0.05, 0.75};
constexpr double line_px = 4.0;

/// One hue per kind of surrounding, one lightness per film of that kind.
Colour film_colour(const Spindle& spindle, std::size_t film) {
  const auto kind_of = [&](std::size_t index) { return spindle.surroundings[spindle.films[index].surrounding].kind; };
  int before = 0;
  for (std::size_t other = 0; other < film; ++other) before += kind_of(other) == kind_of(film) ? 1 : 0;
  double hue_degrees = 145.0;
  if (kind_of(film) == SurroundingKind::coolant) hue_degrees = 255.0;
  if (kind_of(film) == SurroundingKind::air) hue_degrees = 310.0;
  return from_oklch(0.42 + 0.15 * (before % 4), 0.16, hue_degrees);
}

/// Unit normal out of the part, on the picture; the part lies to the left from start to end.
Pixel outward(const BoundaryPiece& piece) {
  const double dr = piece.end.r_m - piece.start.r_m, dz = piece.end.z_m - piece.start.z_m;
  const double length_m = std::hypot(dr, dz);
  return {-dr / length_m, -dz / length_m};
}

void draw_piece(Canvas& canvas, const View& view, const BoundaryPiece& piece, double offset_px, double width_px,
                const Colour& colour, const std::vector<double>& dashes_px = {}) {
  const Pixel normal = outward(piece), from = view.at(piece.start), to = view.at(piece.end);
  canvas.line({from.x + offset_px * normal.x, from.y + offset_px * normal.y},
              {to.x + offset_px * normal.x, to.y + offset_px * normal.y}, width_px, colour, dashes_px);
}

void draw_pieces(Canvas& canvas, const View& view, const SectionPicture& picture) {
  // Contacts last: they are the shortest.
  for (const BoundaryPiece& piece : picture.section.pieces) {
    if (piece.kind == PieceKind::film) {
      draw_piece(canvas, view, piece, 0.4 * line_px, line_px, film_colour(picture.spindle, piece.index));
    } else if (piece.kind == PieceKind::adiabatic) {
      draw_piece(canvas, view, piece, 0.0, 3.0, adiabatic_colour, {6, 4});
    }
  }
  for (const BoundaryPiece& piece : picture.section.pieces) {
    if (piece.kind == PieceKind::gap) draw_piece(canvas, view, piece, 0.0, line_px, gap_colour);
    if (piece.kind != PieceKind::contact || piece.side != 0) continue;
    const bool is_fit = picture.spindle.contacts[piece.index].fit.has_value();
    draw_piece(canvas, view, piece, 0.0, is_fit ? line_px : 2.6, is_fit ? fit_colour : contact_colour);
  }
}

void hatch(Canvas& canvas, const PixelBox& box) {
  constexpr double distance_px = 9.0;
  for (double x = box.x0 - (box.y1 - box.y0); x < box.x1; x += distance_px) {
    canvas.line({x, box.y1}, {x + box.y1 - box.y0, box.y0}, 1.6, heat_colour);
  }
}

void draw_heats(Canvas& canvas, const View& view, const SectionPicture& picture) {
  for (const HeatSource& heat : picture.spindle.heats) {
    for (const HeatShare& share : heat.shares) {
      if (!share.on_contact_with && !share.on_face) {
        for (const OutlineFace& face : picture.section.outlines[share.part].faces) {
          cairo_save(canvas.pen());
          trace(canvas, view, face);
          cairo_clip(canvas.pen());
          hatch(canvas, view.frame);
          cairo_restore(canvas.pen());
        }
        continue;
      }
      for (const BoundaryPiece& piece : picture.section.pieces) {
        if (piece.part != share.part) continue;
        if (share.on_face && !lies_in(piece, *share.on_face)) continue;
        if (share.on_contact_with) {
          if (piece.kind != PieceKind::contact) continue;
          const Contact& contact = picture.spindle.contacts[piece.index];
          if ((piece.side == 0 ? contact.part_b : contact.part_a) != *share.on_contact_with) continue;
        }
        draw_piece(canvas, view, piece, -5.0, 4.5, heat_colour, {3, 4});
      }
    }
  }
}

/// Drawn as fixed ground: a thick line with oblique strokes on the outside.
void draw_support(Canvas& canvas, const Pixel& from, const Pixel& to, const Pixel& normal) {
  canvas.line(from, to, 4.0, ink);
  const double length_px = std::hypot(to.x - from.x, to.y - from.y);
  const int strokes = std::max(2, static_cast<int>(length_px / 8.0));
  const double ux = (to.x - from.x) / length_px, uy = (to.y - from.y) / length_px;
  for (int i = 0; i <= strokes; ++i) {
    const double along_px = length_px * i / strokes;
    const Pixel root{from.x + along_px * ux, from.y + along_px * uy};
    canvas.line(root, {root.x + 11.0 * normal.x + 7.0 * ux, root.y + 11.0 * normal.y + 7.0 * uy}, 1.8, ink);
  }
}

void draw_markers(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  const Spindle& spindle = picture.spindle;
  const TextStyle label{17.0, true, Align::centre, ink, true};
  for (const Support& support : spindle.supports) {
    const BoundaryPiece* last = nullptr;
    for (const BoundaryPiece& piece : picture.section.pieces) {
      if (piece.part != support.part || !lies_in(piece, support.face)) continue;
      draw_support(canvas, view.at(piece.start), view.at(piece.end), outward(piece));
      last = &piece;
    }
    if (!last) continue;
    const Pixel from = view.at(last->start), to = view.at(last->end), normal = outward(*last);
    const Pixel at{0.5 * (from.x + to.x) + 14.0 * normal.x, 0.5 * (from.y + to.y) + 14.0 * normal.y};
    board.keep_free({std::min({from.x, to.x, at.x}) - 3, std::min({from.y, to.y, at.y}) - 3,
                     std::max({from.x, to.x, at.x}) + 8, std::max({from.y, to.y, at.y}) + 8});
    board.add(at, "support", label);
  }
  for (const DeformationOutput& output : spindle.deformations) {
    for (const BoundaryPiece& piece : picture.section.pieces) {
      if (piece.part != output.part || !lies_in(piece, output.face)) continue;
      draw_piece(canvas, view, piece, 0.0, 6.0, {0.0, 0.0, 0.0, 1.0});
    }
    const Pixel at =
        view.at({0.5 * (output.face.r0_m + output.face.r1_m), 0.5 * (output.face.z0_m + output.face.z1_m)});
    constexpr double length_px = 46.0;
    const bool is_radial = output.direction == Direction::radial;
    const Pixel tip{at.x + (is_radial ? 0.0 : output.sign * length_px),
                    at.y - (is_radial ? output.sign * length_px : 0.0)};
    canvas.arrow(at, tip, {0.0, 0.0, 0.0, 1.0});
    board.keep_free(
        {std::min(at.x, tip.x) - 6, std::min(at.y, tip.y) - 6, std::max(at.x, tip.x) + 6, std::max(at.y, tip.y) + 6});
    board.add(tip, output.name, label);
  }
  for (const KeyPoint& point : spindle.key_points) {
    const Pixel at = view.at(point.at);
    canvas.disc(at, 6.0, {1.0, 0.85, 0.1, 1.0}, ink);
    board.add(at, point.name, label);
  }
}

double distance_to(const Pixel& at, const Pixel& a, const Pixel& b) {
  const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
  const double share = square > 0.0 ? std::clamp(((at.x - a.x) * dx + (at.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(at.x - a.x - share * dx, at.y - a.y - share * dy);
}

/// A label's middle and how far its own middle line stays from the outline.
struct LabelPlace {
  Pixel at;
  double clearance_px = -1.0;
};

/// The place inside the face where a label of this width has the most room above and below it.
LabelPlace best_place(Canvas& canvas, const View& view, const OutlineFace& face, const LabelBoard& board,
                      double half_width_px) {
  std::vector<std::pair<Pixel, Pixel>> sides;
  PixelBox box{1e9, 1e9, -1e9, -1e9};
  const auto add = [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Pixel a = view.at(ring[i]);
      sides.emplace_back(a, view.at(ring[(i + 1) % ring.size()]));
      box = {std::min(box.x0, a.x), std::min(box.y0, a.y), std::max(box.x1, a.x), std::max(box.y1, a.y)};
    }
  };
  add(face.outer);
  for (const Polygon& hole : face.holes) add(hole);
  cairo_new_path(canvas.pen());
  trace(canvas, view, face);
  LabelPlace best;
  double best_score = -1e9;
  constexpr int samples = 48;
  for (int j = 1; j < samples; ++j) {
    for (int i = 1; i < samples; ++i) {
      const Pixel at{box.x0 + (box.x1 - box.x0) * i / samples, box.y0 + (box.y1 - box.y0) * j / samples};
      double clearance_px = std::numeric_limits<double>::max();
      for (const double shift : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        const Pixel probe{at.x + shift * half_width_px, at.y};
        if (!cairo_in_fill(canvas.pen(), probe.x, probe.y)) clearance_px = -1.0;
        for (const auto& [a, b] : sides) clearance_px = std::min(clearance_px, distance_to(probe, a, b));
      }
      const double off_centre_px = std::hypot(at.x - 0.5 * (box.x0 + box.x1), at.y - 0.5 * (box.y0 + box.y1));
      const double score = std::min(clearance_px, 22.0) - 0.01 * off_centre_px;
      if (clearance_px > 0.0 && score > best_score &&
          board.is_free({at.x - half_width_px, at.y - 9, at.x + half_width_px, at.y + 9})) {
        best_score = score;
        best = {at, clearance_px};
      }
    }
  }
  cairo_new_path(canvas.pen());
  return best;
}

/// The part's number, with its name where there is room for it.
void label_parts(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  for (std::size_t part = 0; part < picture.section.outlines.size(); ++part) {
    const std::string number = std::to_string(part + 1);
    const std::string whole = number + " " + picture.spindle.parts[part].name;
    for (const OutlineFace& face : picture.section.outlines[part].faces) {
      TextStyle style{17.0, true, Align::centre, ink, true};
      LabelPlace place = best_place(canvas, view, face, board, 0.5 * canvas.text_width_px(whole, style) + 3.0);
      const bool has_name = place.clearance_px > 10.0;
      if (!has_name) {
        place = best_place(canvas, view, face, board, 0.5 * canvas.text_width_px(number, style) * 0.7);
        style.size_px = std::clamp(1.5 * place.clearance_px, 10.0, 17.0);
      }
      if (place.clearance_px <= 0.0) continue;
      const std::string& words = has_name ? whole : number;
      const double half_px = 0.5 * canvas.text_width_px(words, style);
      board.keep_free({place.at.x - half_px, place.at.y - 10, place.at.x + half_px, place.at.y + 10});
      canvas.text(place.at, words, style);
    }
  }
}

LegendLine line_entry(const Colour& colour, double width_px, const std::vector<double>& dashes_px,
                      const std::string& words, const std::string& value) {
  return {[=](Canvas& canvas, const PixelBox& box) {
            const double y = 0.5 * (box.y0 + box.y1);
            canvas.line({box.x0, y}, {box.x1, y}, width_px, colour, dashes_px);
          },
          words, value};
}

std::string per_square_metre(double value_W_per_m2K) {
  return fixed(value_W_per_m2K, value_W_per_m2K < 100.0 ? 1 : 0) + " W/m²K";
}

std::vector<LegendGroup> legend_of(const SectionPicture& picture) {
  const Spindle& spindle = picture.spindle;
  LegendGroup parts{"Parts and their materials", {}};
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    parts.lines.push_back({[part](Canvas& canvas, const PixelBox& box) {
                             canvas.fill_box(box, part_colour(part));
                             canvas.frame_box(box, 1.0, ink);
                             canvas.text({0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)}, std::to_string(part + 1),
                                         {14.0, true, Align::centre, ink});
                           },
                           spindle.parts[part].name, spindle.materials[spindle.parts[part].material].name});
  }
  LegendGroup surfaces{"Surfaces, coefficients at the reference state", {}};
  const auto add_contacts = [&](bool with_fit, const Colour& colour, const std::string& words) {
    double least = std::numeric_limits<double>::max(), most = 0.0;
    int count = 0;
    for (const Contact& contact : spindle.contacts) {
      if (contact.fit.has_value() != with_fit) continue;
      least = std::min(least, contact.conductance_W_per_m2K);
      most = std::max(most, contact.conductance_W_per_m2K);
      ++count;
    }
    if (count == 0) return;
    surfaces.lines.push_back(line_entry(colour, with_fit ? line_px : 2.6, {}, std::to_string(count) + " " + words,
                                        fixed(least, 0) + " to " + per_square_metre(most)));
  };
  add_contacts(false, contact_colour, "contacts");
  add_contacts(true, fit_colour, "contacts with a fit");
  for (const GapFilm& gap : spindle.gap_films) {
    surfaces.lines.push_back(
        line_entry(gap_colour, line_px, {}, "gap: " + gap.name, per_square_metre(gap.coefficient_W_per_m2K)));
  }
  for (std::size_t film = 0; film < spindle.films.size(); ++film) {
    surfaces.lines.push_back(
        line_entry(film_colour(spindle, film), 1.6 * line_px, {},
                   spindle.films[film].name + " → " + spindle.surroundings[spindle.films[film].surrounding].name,
                   per_square_metre(spindle.films[film].coefficient_W_per_m2K)));
  }
  if (!spindle.adiabatics.empty()) surfaces.lines.push_back(line_entry(adiabatic_colour, 3.0, {6, 4}, "adiabatic", ""));
  LegendGroup heats{"Heat sources (hatched: in the volume; dotted: on a face) and outputs", {}};
  for (const NamedValue& heat : picture.heats_W) {
    heats.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             cairo_save(canvas.pen());
                             cairo_rectangle(canvas.pen(), box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0);
                             cairo_clip(canvas.pen());
                             hatch(canvas, box);
                             cairo_restore(canvas.pen());
                           },
                           heat.name, fixed(heat.value, 1) + " W"});
  }
  if (!spindle.key_points.empty()) {
    heats.lines.push_back(
        {[](Canvas& canvas, const PixelBox& box) {
           canvas.disc({0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)}, 6.0, {1.0, 0.85, 0.1, 1.0}, ink);
         },
         "key point", ""});
  }
  if (!spindle.deformations.empty()) {
    heats.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             const double y = 0.5 * (box.y0 + box.y1);
                             canvas.arrow({box.x1, y}, {box.x0, y}, {0.0, 0.0, 0.0, 1.0});
                           },
                           "deformation output, its positive sense", ""});
  }
  if (!spindle.supports.empty()) {
    heats.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             draw_support(canvas, {box.x0, box.y0 + 4}, {box.x1 - 6, box.y0 + 4}, {0.0, 1.0});
                           },
                           "support", ""});
  }
  return {std::move(parts), std::move(surfaces), std::move(heats)};
}

}  // namespace

void draw_parts_picture(const SectionPicture& picture, const std::string& path) {
  const View view = make_view(picture.lattice);
  const std::vector<LegendGroup> groups = legend_of(picture);
  constexpr int columns = 4;
  const double legend_top = view.frame.y1 + 75.0;
  Canvas canvas(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, columns));
  draw_title(canvas, picture.spindle.name + ": parts, contacts, films and heat sources",
             "meridian section; nominal values of the description at " + fixed(picture.spindle.operating.speed_rpm, 0) +
                 " rpm, load " + fixed(picture.spindle.operating.load, 2));
  fill_parts(canvas, view, picture.section);
  draw_heats(canvas, view, picture);
  stroke_edges(canvas, view, picture.lattice.nodes, edges_of(picture.lattice, true), 1.0, ink);
  draw_pieces(canvas, view, picture);
  draw_axes(canvas, view);
  LabelBoard board(canvas, {20, 95, picture_width_px - 20, view.frame.y1});
  for (const KeyPoint& point : picture.spindle.key_points) {
    const Pixel at = view.at(point.at);
    board.keep_free({at.x - 7, at.y - 7, at.x + 7, at.y + 7});
  }
  label_parts(canvas, view, picture, board);
  draw_markers(canvas, view, picture, board);
  board.draw();
  draw_legend(canvas, legend_top, groups, columns);
  canvas.save(path);
}

}  // namespace spindle_twin::fem_offline
