#include <algorithm>
#include <cmath>
#include <limits>

#include "fem_offline/look/picture_frame.hpp"

namespace spindle_twin::fem_offline {
namespace {

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

/// The place inside the face where a label of this width has the most room above and below it; `letters` is what it
/// covers around its place.
LabelPlace best_place(Canvas& canvas, const View& view, const OutlineFace& face, const LabelBoard& board,
                      double half_width_px, const PixelBox& letters) {
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
          board.is_free({at.x + letters.x0, at.y + letters.y0, at.x + letters.x1, at.y + letters.y1})) {
        best_score = score;
        best = {at, clearance_px};
      }
    }
  }
  cairo_new_path(canvas.pen());
  return best;
}

/// The part's number, with its name where there is room for it; beside a part in which no face has room.
void label_parts(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  for (std::size_t part = 0; part < picture.section.outlines.size(); ++part) {
    const std::string number = std::to_string(part + 1);
    const std::string whole = number + " " + picture.spindle.parts[part].name;
    const std::vector<OutlineFace>& faces = picture.section.outlines[part].faces;
    bool is_labelled = false;
    for (const OutlineFace& face : faces) {
      TextStyle style{17.0, true, Align::centre, ink, true};
      LabelPlace place = best_place(canvas, view, face, board, 0.5 * canvas.text_width_px(whole, style) + 3.0,
                                    canvas.text_box({}, whole, style));
      const bool has_name = place.clearance_px > 10.0;
      if (!has_name) {
        place = best_place(canvas, view, face, board, 0.5 * canvas.text_width_px(number, style) * 0.7,
                           canvas.text_box({}, number, style));
        style.size_px = std::clamp(1.5 * place.clearance_px, 10.0, 17.0);
      }
      if (place.clearance_px <= 0.0) continue;
      canvas.text(place.at, has_name ? whole : number, style);
      is_labelled = true;
    }
    if (!is_labelled && !faces.empty()) {
      board.add(box_of(view.at(faces.front().outer.front())), number, {15.0, true, Align::centre, ink, true});
    }
  }
}

LegendGroup parts_legend(const Spindle& spindle) {
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
  return parts;
}

}  // namespace

std::unique_ptr<Canvas> draw_parts_picture(const SectionPicture& picture) {
  const Spindle& spindle = picture.spindle;
  const View view = make_view(picture.lattice.nodes, spindle.geometry);
  const std::vector<LegendGroup> groups{parts_legend(spindle), surfaces_legend(spindle), circuits_legend(spindle),
                                        heats_legend(picture), points_legend(spindle),   supports_legend(spindle)};
  const int columns = circuits_legend(spindle).lines.empty() ? 4 : 3;
  const double legend_top = view.frame.y1 + 75.0;
  auto made =
      std::make_unique<Canvas>(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, columns));
  Canvas& canvas = *made;
  draw_title(canvas, spindle.name + ": parts, contacts, films and heat sources",
             section_words(spindle) + "; nominal values of the description: " + fixed(spindle.operating.speed_rpm, 0) +
                 " rpm, full load");
  fill_parts(canvas, view, picture.section);
  draw_heats(canvas, view, picture);
  stroke_edges(canvas, view, picture.lattice.nodes, rim_of(picture.lattice), 1.0, ink);
  draw_surfaces(canvas, view, picture);
  draw_axes(canvas, view);
  LabelBoard board(canvas, {view.frame.x0, 95, picture_width_px - 20, view.frame.y1});
  add_key_points(view, spindle, board);
  draw_circuits(canvas, view, picture, board);
  board.place();
  draw_outputs(canvas, view, picture, board);
  draw_supports(canvas, view, picture, board);
  label_parts(canvas, view, picture, board);
  board.draw();
  draw_legend(canvas, legend_top, groups, columns);
  return made;
}

}  // namespace spindle_twin::fem_offline
