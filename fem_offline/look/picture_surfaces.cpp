#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "fem_offline/look/picture_frame.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr Colour fit_colour{0.85, 0.05, 0.10, 1.0};
constexpr double fit_line_px = 4.0, white_line_px = 2.8;
constexpr double grams_per_kg = 1e3;

/// What is drawn alike: a film by itself, or all segments of a circuit.
struct DrawnFilm {
  std::size_t film = 0;
  const CoolantCircuit* circuit = nullptr;
};

std::optional<std::size_t> circuit_of(const Spindle& spindle, std::size_t film) {
  for (std::size_t c = 0; c < spindle.circuits.size(); ++c) {
    const auto& segments = spindle.circuits[c].segments;
    if (std::find(segments.begin(), segments.end(), film) != segments.end()) return c;
  }
  return std::nullopt;
}

std::vector<DrawnFilm> drawn_films(const Spindle& spindle) {
  std::vector<DrawnFilm> drawn;
  for (std::size_t film = 0; film < spindle.films.size(); ++film) {
    if (!circuit_of(spindle, film)) drawn.push_back({film});
  }
  for (const CoolantCircuit& circuit : spindle.circuits) drawn.push_back({circuit.segments.front(), &circuit});
  return drawn;
}

std::optional<Colour> own_colour(const FaceMark& mark) {
  if (!mark.colour) return std::nullopt;
  const auto [red, green, blue, opacity] = *mark.colour;
  return Colour{red, green, blue, opacity};
}

std::vector<double> dashes_px(const FaceMark& mark) {
  return mark.dashes_px[0] > 0.0 ? std::vector<double>(mark.dashes_px.begin(), mark.dashes_px.end())
                                 : std::vector<double>{};
}

/// That of its condition; without one, one hue per kind of surrounding and one lightness per film of that kind, all
/// segments of a circuit as the first.
Colour film_colour(const Spindle& spindle, std::size_t film) {
  if (const auto colour = own_colour(spindle.films[film].condition->mark)) return *colour;
  const auto kind_of = [&](std::size_t index) { return spindle.surroundings[spindle.films[index].surrounding].kind; };
  const auto circuit = circuit_of(spindle, film);
  const std::size_t shown = circuit ? spindle.circuits[*circuit].segments.front() : film;
  int before = 0;
  for (const DrawnFilm& other : drawn_films(spindle)) {
    if (other.film == shown) break;
    if (!spindle.films[other.film].condition->mark.colour && kind_of(other.film) == kind_of(shown)) ++before;
  }
  double hue_degrees = 145.0;
  if (kind_of(shown) == SurroundingKind::coolant) hue_degrees = 255.0;
  if (kind_of(shown) == SurroundingKind::air) hue_degrees = 310.0;
  return from_oklch(0.42 + 0.15 * (before % 4), 0.16, hue_degrees);
}

/// The mark of the condition that holds the index-th item of a kind of piece, along this piece.
void draw_condition(Canvas& canvas, const View& view, const Spindle& spindle, const BoundaryPiece& piece,
                    PieceKind kind, std::size_t index) {
  const FaceMark& mark = face_condition(spindle, kind, index).mark;
  const Colour colour = kind == PieceKind::film ? film_colour(spindle, index) : own_colour(mark).value_or(ink);
  const std::vector<double> dashes = dashes_px(mark);
  draw_piece(canvas, view, piece,
             {mark.offset_px, mark.width_px, colour, mark.white_dashes ? std::vector<double>{} : dashes});
  if (mark.white_dashes) draw_piece(canvas, view, piece, {mark.offset_px, white_line_px, white, dashes});
}

void hatch(Canvas& canvas, const PixelBox& box, const Colour& colour) {
  constexpr double distance_px = 9.0;
  for (double x = box.x0 - (box.y1 - box.y0); x < box.x1; x += distance_px) {
    canvas.line({x, box.y1}, {x + box.y1 - box.y0, box.y0}, 1.6, colour);
  }
}

LegendLine line_entry(const Colour& colour, double width_px, const std::string& words, const std::string& value) {
  return {[=](Canvas& canvas, const PixelBox& box) {
            const double y = 0.5 * (box.y0 + box.y1);
            canvas.line({box.x0, y}, {box.x1, y}, width_px, colour);
          },
          words, value};
}

LegendLine mark_entry(const FaceMark& mark, const Colour& colour, const std::string& words, const std::string& value) {
  return {[=](Canvas& canvas, const PixelBox& box) {
            const double y = 0.5 * (box.y0 + box.y1);
            const std::vector<double> dashes = dashes_px(mark);
            canvas.line({box.x0, y}, {box.x1, y}, mark.legend_width_px, colour,
                        mark.white_dashes ? std::vector<double>{} : dashes);
            if (mark.white_dashes) canvas.line({box.x0, y}, {box.x1, y}, white_line_px, white, dashes);
          },
          std::string(mark.legend) + words, value};
}

std::string per_square_metre(double value_W_per_m2K) { return compact(value_W_per_m2K) + " W/m²K"; }

std::string range_of(double least, double most) {
  return (least < most ? compact(least) + " to " : "") + per_square_metre(most);
}

LegendLine film_entry(const Spindle& spindle, std::size_t index) {
  const Film& film = spindle.films[index];
  const FaceMark& mark = film.condition->mark;
  const Surrounding& surrounding = spindle.surroundings[film.surrounding];
  const Colour colour = film_colour(spindle, index);
  if (film.condition->assembles == Assembles::held_temperature) {
    const double held_K = spindle.operating.surrounding_K[film.surrounding];
    return mark_entry(mark, colour, film.name, surrounding.name + " " + fixed(held_K - rom::zero_degC_K, 1) + " °C");
  }
  return mark_entry(mark, colour, film.name + " → " + surrounding.name, per_square_metre(film.coefficient_W_per_m2K));
}

/// Middle of the wetted faces of a segment: in a groove or bore the liquid itself.
std::optional<Pixel> middle_of(const View& view, const Section& section, std::size_t film) {
  double length_m = 0.0, r_m2 = 0.0, z_m2 = 0.0;
  for (const BoundaryPiece& piece : section.pieces) {
    if (piece.kind != PieceKind::film || piece.index != film) continue;
    const double piece_m = std::hypot(piece.end.r_m - piece.start.r_m, piece.end.z_m - piece.start.z_m);
    length_m += piece_m;
    r_m2 += 0.5 * piece_m * (piece.start.r_m + piece.end.r_m);
    z_m2 += 0.5 * piece_m * (piece.start.z_m + piece.end.z_m);
  }
  if (length_m == 0.0) return std::nullopt;
  return view.at({r_m2 / length_m, z_m2 / length_m});
}

}  // namespace

Pixel outward(const BoundaryPiece& piece) {
  const double dr = piece.end.r_m - piece.start.r_m, dz = piece.end.z_m - piece.start.z_m;
  const double length_m = std::hypot(dr, dz);
  return {-dr / length_m, -dz / length_m};
}

void draw_piece(Canvas& canvas, const View& view, const BoundaryPiece& piece, const PieceLine& line) {
  const Pixel normal = outward(piece), from = view.at(piece.start), to = view.at(piece.end);
  cairo_set_line_cap(canvas.pen(), line.dashes_px.empty() ? CAIRO_LINE_CAP_ROUND : CAIRO_LINE_CAP_BUTT);
  canvas.line({from.x + line.offset_px * normal.x, from.y + line.offset_px * normal.y},
              {to.x + line.offset_px * normal.x, to.y + line.offset_px * normal.y}, line.width_px, line.colour,
              line.dashes_px);
  cairo_set_line_cap(canvas.pen(), CAIRO_LINE_CAP_BUTT);
}

void draw_surfaces(Canvas& canvas, const View& view, const SectionPicture& picture) {
  const Spindle& spindle = picture.spindle;
  const auto draw_own = [&](const BoundaryPiece& piece) {
    draw_condition(canvas, view, spindle, piece, piece.kind, piece.index);
  };
  for (const BoundaryPiece& piece : picture.section.pieces) {
    if (piece.kind == PieceKind::film || piece.kind == PieceKind::adiabatic) draw_own(piece);
    for (const std::size_t film : piece.beside) draw_condition(canvas, view, spindle, piece, PieceKind::film, film);
  }
  // Contacts last: they are the shortest.
  for (const BoundaryPiece& piece : picture.section.pieces) {
    if (piece.kind == PieceKind::gap) draw_own(piece);
    if (piece.kind != PieceKind::contact || piece.side != 0) continue;
    if (spindle.contacts[piece.index].fit) {
      draw_piece(canvas, view, piece, {0.0, fit_line_px, fit_colour});
    } else {
      draw_own(piece);
    }
  }
}

LegendGroup surfaces_legend(const Spindle& spindle) {
  LegendGroup surfaces{"Surfaces, coefficients at the reference state", {}};
  const auto marked = [](std::string_view table, const std::string& words, const std::string& value) {
    const FaceMark& mark = face_condition(table).mark;
    return mark_entry(mark, own_colour(mark).value_or(ink), words, value);
  };
  const auto add_contacts = [&](bool with_fit) {
    double least = std::numeric_limits<double>::max(), most = 0.0;
    int count = 0;
    for (const Contact& contact : spindle.contacts) {
      if (contact.fit.has_value() != with_fit) continue;
      least = std::min(least, contact.conductance_W_per_m2K);
      most = std::max(most, contact.conductance_W_per_m2K);
      ++count;
    }
    if (count == 0) return;
    const std::string words = std::to_string(count) + (count == 1 ? " contact" : " contacts");
    surfaces.lines.push_back(with_fit
                                 ? line_entry(fit_colour, fit_line_px, words + " with a fit", range_of(least, most))
                                 : marked("contact", words, range_of(least, most)));
  };
  add_contacts(false);
  add_contacts(true);
  for (const GapFilm& gap : spindle.gap_films) {
    surfaces.lines.push_back(marked("gap_film", gap.name, per_square_metre(gap.coefficient_W_per_m2K)));
  }
  for (const DrawnFilm& drawn : drawn_films(spindle)) {
    if (!drawn.circuit) surfaces.lines.push_back(film_entry(spindle, drawn.film));
  }
  if (!spindle.adiabatics.empty()) surfaces.lines.push_back(marked("adiabatic", "", ""));
  return surfaces;
}

void draw_circuits(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  const TextStyle style{15.0, true, Align::centre, ink, true};
  for (const CoolantCircuit& circuit : picture.spindle.circuits) {
    std::vector<Pixel> way;
    for (const std::size_t segment : circuit.segments) {
      if (const auto at = middle_of(view, picture.section, segment)) way.push_back(*at);
    }
    if (way.empty()) continue;
    if (circuit.flow_kg_per_s < 0.0) std::reverse(way.begin(), way.end());
    const Colour colour = film_colour(picture.spindle, circuit.segments.front());
    for (std::size_t i = 0; i + 1 < way.size(); ++i) {
      const double length_px = std::hypot(way[i + 1].x - way[i].x, way[i + 1].y - way[i].y);
      if (circuit.flow_kg_per_s == 0.0) {
        canvas.line(way[i], way[i + 1], 2.0, colour, {3, 5});
        continue;
      }
      constexpr double clear_px = 16.0;  // around the place of a segment
      if (length_px < 3.0 * clear_px) continue;
      const double ux = clear_px * (way[i + 1].x - way[i].x) / length_px;
      const double uy = clear_px * (way[i + 1].y - way[i].y) / length_px;
      canvas.arrow({way[i].x + ux, way[i].y + uy}, {way[i + 1].x - ux, way[i + 1].y - uy}, colour);
    }
    for (std::size_t i = 0; i < way.size(); ++i) {
      board.add_on(way[i], std::to_string(i + 1), {15.0, true, Align::centre, colour, true});
    }
    const auto around = [](const Pixel& at) { return PixelBox{at.x - 12, at.y - 10, at.x + 12, at.y + 10}; };
    board.add(around(way.front()), circuit.name + (circuit.flow_kg_per_s == 0.0 ? ", no flow" : " in"), style);
    if (way.size() > 1 && circuit.flow_kg_per_s != 0.0) board.add(around(way.back()), circuit.name + " out", style);
  }
}

LegendGroup circuits_legend(const Spindle& spindle) {
  LegendGroup group{"Coolant circuits: segments numbered in the order of the flow, film coefficients in all segments",
                    {}};
  for (const CoolantCircuit& circuit : spindle.circuits) {
    const Colour colour = film_colour(spindle, circuit.segments.front());
    double least = std::numeric_limits<double>::max(), most = 0.0;
    for (const std::size_t segment : circuit.segments) {
      least = std::min(least, spindle.films[segment].coefficient_W_per_m2K);
      most = std::max(most, spindle.films[segment].coefficient_W_per_m2K);
    }
    group.lines.push_back({[colour](Canvas& canvas, const PixelBox& box) {
                             const double y = 0.5 * (box.y0 + box.y1);
                             canvas.arrow({box.x0, y}, {box.x1, y}, colour);
                           },
                           circuit.name + ", " + spindle.surroundings[circuit.inlet].name + " " +
                               fixed(spindle.operating.surrounding_K[circuit.inlet] - rom::zero_degC_K, 1) + " °C, " +
                               compact(grams_per_kg * std::abs(circuit.flow_kg_per_s)) + " g/s" +
                               (circuit.flow_kg_per_s < 0.0 ? " backwards" : ""),
                           range_of(least, most)});
  }
  return group;
}

void draw_heats(Canvas& canvas, const View& view, const SectionPicture& picture) {
  const FaceMark& heat_mark = face_condition("heat").mark;
  const Colour heat_colour = own_colour(heat_mark).value_or(ink);
  for (const HeatSource& heat : picture.spindle.heats) {
    for (const HeatShare& share : heat.shares) {
      if (!share.on_contact_with && !share.on_face) {
        for (const OutlineFace& face : picture.section.outlines[share.part].faces) {
          cairo_save(canvas.pen());
          trace(canvas, view, face);
          cairo_clip(canvas.pen());
          hatch(canvas, view.frame, heat_colour);
          cairo_restore(canvas.pen());
        }
        continue;
      }
      for (const BoundaryPiece& piece : picture.section.pieces) {
        if (!carries(picture.spindle, piece, share)) continue;
        draw_piece(canvas, view, piece, {heat_mark.offset_px, heat_mark.width_px, heat_colour, dashes_px(heat_mark)});
      }
    }
  }
}

LegendGroup heats_legend(const SectionPicture& picture) {
  const Spindle& spindle = picture.spindle;
  LegendGroup heats{"Heat sources (hatched: in the volume; dotted: on a face)", {}};
  const FaceMark& mark = face_condition("heat").mark;  // outlives the lambdas: a row of the table
  const Colour colour = own_colour(mark).value_or(ink);
  const std::string watt = spindle.geometry == Geometry::planar ? " W/m" : " W";
  for (std::size_t h = 0; h < picture.heats_W.size(); ++h) {
    const HeatSource& heat = spindle.heats[h];
    bool in_volume = false, on_face = false;
    for (const HeatShare& share : heat.shares) {
      const bool is_face = share.on_contact_with || share.on_face;
      in_volume = in_volume || !is_face;
      on_face = on_face || is_face;
    }
    std::string value = compact(picture.heats_W[h].value) + watt;
    if (heat.flux_W_per_m2) value.insert(0, compact(*heat.flux_W_per_m2) + " W/m², ");
    heats.lines.push_back({[=, &mark](Canvas& canvas, const PixelBox& box) {
                             if (in_volume) {
                               cairo_save(canvas.pen());
                               cairo_rectangle(canvas.pen(), box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0);
                               cairo_clip(canvas.pen());
                               hatch(canvas, box, colour);
                               cairo_restore(canvas.pen());
                             }
                             const double y = in_volume ? box.y1 : 0.5 * (box.y0 + box.y1);
                             if (on_face)
                               canvas.line({box.x0, y}, {box.x1, y}, mark.legend_width_px, colour, dashes_px(mark));
                           },
                           heat.name, value});
  }
  return heats;
}

}  // namespace spindle_twin::fem_offline
