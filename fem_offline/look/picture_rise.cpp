#include <algorithm>
#include <cmath>
#include <set>

#include "fem_offline/look/picture_frame.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Least and greatest value of every part and where they are.
struct Extremes {
  int least_node = -1;
  int most_node = -1;
};

std::vector<Extremes> extremes_of(const SectionPicture& picture, const Eigen::VectorXd& field) {
  std::vector<Extremes> extremes(picture.spindle.parts.size());
  for (const LatticeCell& cell : picture.lattice.cells) {
    Extremes& part = extremes[cell.part];
    for (const int node : cell.nodes) {
      if (part.least_node < 0 || field[node] < field[part.least_node]) part.least_node = node;
      if (part.most_node < 0 || field[node] > field[part.most_node]) part.most_node = node;
    }
  }
  return extremes;
}

/// Every level with its isoline.
using Isolines = std::vector<std::pair<double, std::vector<IsolinePiece>>>;

Isolines draw_isolines(Canvas& canvas, const View& view, const SectionPicture& picture,
                       const std::vector<LatticeTriangle>& triangles, const FieldScale& scale) {
  Isolines lines;
  for (const double level : scale.levels()) {
    lines.emplace_back(level, isoline(picture.lattice, triangles, picture.rises_K, level));
    for (const IsolinePiece& piece : lines.back().second) {
      const Pixel from = view.at(piece.start), to = view.at(piece.end);
      cairo_move_to(canvas.pen(), from.x, from.y);
      cairo_line_to(canvas.pen(), to.x, to.y);
    }
    cairo_set_line_width(canvas.pen(), 1.1);
    canvas.set_colour({1.0, 1.0, 1.0, 0.9});
    cairo_stroke(canvas.pen());
  }
  return lines;
}

/// Their levels on them, some distance from each other, where nothing else stands.
void label_isolines(Canvas& canvas, const View& view, const Isolines& lines, const FieldScale& scale,
                    const LabelBoard& board) {
  constexpr double apart_px = 330.0;
  for (const auto& [level, pieces] : lines) {
    std::vector<Pixel> labelled;
    const TextStyle style{13.0, false, Align::centre, ink, true};
    const std::string words = fixed(level, scale.digits());
    for (const IsolinePiece& piece : pieces) {
      const Pixel at = view.at(piece.start);
      const bool is_near = std::any_of(labelled.begin(), labelled.end(), [&](const Pixel& other) {
        return std::hypot(other.x - at.x, other.y - at.y) < apart_px;
      });
      if (is_near || !board.is_free(canvas.text_box(at, words, style))) continue;
      labelled.push_back(at);
      canvas.text(at, words, style);
    }
  }
}

void mark_extreme(Canvas& canvas, const Pixel& at) {
  constexpr double half_px = 6.0;
  for (const auto& [width_px, colour] : {std::pair{4.5, Colour{1, 1, 1, 0.9}}, std::pair{2.0, ink}}) {
    canvas.line({at.x - half_px, at.y - half_px}, {at.x + half_px, at.y + half_px}, width_px, colour);
    canvas.line({at.x - half_px, at.y + half_px}, {at.x + half_px, at.y - half_px}, width_px, colour);
  }
}

PixelBox cross_box(const Pixel& at) { return {at.x - 7, at.y - 7, at.x + 7, at.y + 7}; }

/// Part numbers are those of the picture of the parts.
LegendGroup extremes_legend(const SectionPicture& picture, const std::vector<Extremes>& extremes) {
  LegendGroup group{"Rise in K: least to greatest of every part (cross: hottest place of a part with a heat source)",
                    {}};
  for (std::size_t part = 0; part < extremes.size(); ++part) {
    group.lines.push_back(
        {[part](Canvas& canvas, const PixelBox& box) {
           canvas.text({box.x1, 0.5 * (box.y0 + box.y1)}, std::to_string(part + 1), {16.0, true, Align::right, ink});
         },
         picture.spindle.parts[part].name,
         fixed(picture.rises_K[extremes[part].least_node], 2) + " to " +
             fixed(picture.rises_K[extremes[part].most_node], 2)});
  }
  return group;
}

std::vector<LegendGroup> legends(const SectionPicture& picture, const std::vector<Extremes>& extremes) {
  LegendGroup points{"Rise of key points in K", {}}, air{"Rise of enclosed air in K", {}};
  for (std::size_t k = 0; k < picture.key_point_rises_K.size(); ++k) {
    const NamedValue& point = picture.key_point_rises_K[k];
    points.lines.push_back({[k](Canvas& canvas, const PixelBox& box) {
                              const Pixel middle{box.x1 - 10.0, 0.5 * (box.y0 + box.y1)};
                              draw_letter_disc(canvas, middle, letter_of(k));
                            },
                            point.name, fixed(point.value, 2)});
  }
  for (const NamedValue& volume : picture.air_rises_K) {
    air.lines.push_back({{}, volume.name, fixed(volume.value, 2)});
  }
  return {extremes_legend(picture, extremes), points, air};
}

/// Crosses at the hottest places of parts with a heat source and at the hottest of all, which is told in full; it comes
/// first, so that it gets the best place.
void mark_hottest(Canvas& canvas, const View& view, const SectionPicture& picture,
                  const std::vector<Extremes>& extremes, LabelBoard& board) {
  const auto most = [&](std::size_t part) { return picture.rises_K[extremes[part].most_node]; };
  const auto place_of = [&](std::size_t part) { return view.at(picture.lattice.nodes[extremes[part].most_node]); };
  std::set<std::size_t> found;
  for (const HeatSource& heat : picture.spindle.heats) {
    for (const HeatShare& share : heat.shares) found.insert(share.part);
  }
  for (std::size_t part = 0; part < extremes.size(); ++part) {
    if (most(part) == picture.rises_K.maxCoeff()) found.insert(part);
  }
  std::vector<std::size_t> marked(found.begin(), found.end());
  std::sort(marked.begin(), marked.end(), [&](std::size_t a, std::size_t b) { return most(a) > most(b); });
  for (const std::size_t part : marked) {
    const Pixel at = place_of(part);
    mark_extreme(canvas, at);
    board.keep_free(cross_box(at));
  }
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const std::string number = std::to_string(marked[i] + 1);
    const std::string whole =
        number + " " + picture.spindle.parts[marked[i]].name + " " + fixed(most(marked[i]), 2) + " K";
    board.add(cross_box(place_of(marked[i])), i == 0 ? whole : number,
              {i == 0 ? 19.0 : 15.0, true, Align::centre, ink, true});
  }
}

}  // namespace

std::unique_ptr<Canvas> draw_rise_picture(const SectionPicture& picture) {
  const View view = make_view(picture.lattice.nodes, picture.spindle.geometry);
  const std::vector<Extremes> extremes = extremes_of(picture, picture.rises_K);
  const std::vector<LegendGroup> groups = legends(picture, extremes);
  const double legend_top = view.frame.y1 + below_section_px;
  auto made = std::make_unique<Canvas>(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, 4));
  Canvas& canvas = *made;
  draw_title(canvas, picture.spindle.name + ": temperature rise", picture.state.title);

  const std::vector<LatticeTriangle> triangles = triangles_of(picture.lattice);
  const FieldScale scale = make_scale(picture.rises_K.minCoeff(), picture.rises_K.maxCoeff());
  fill_field(canvas, view, picture.lattice.nodes, triangles, picture.rises_K, scale);
  stroke_edges(canvas, view, picture.lattice.nodes, rim_of(picture.lattice), 1.3, rim_colour);
  draw_axes(canvas, view);

  LabelBoard board(canvas, {view.frame.x0, 95, view.frame.x1, view.frame.y1});
  add_key_points(view, picture.spindle, board);
  board.place();
  const Isolines lines = draw_isolines(canvas, view, picture, triangles, scale);
  mark_hottest(canvas, view, picture, extremes, board);
  board.draw();
  label_isolines(canvas, view, lines, scale, board);
  const std::string datum = fixed(picture.state.datum_K - rom::zero_degC_K, 2);
  draw_colour_bar(canvas, bar_box(view), scale, "rise in K above " + datum + " °C");
  draw_legend(canvas, legend_top, groups, 4);
  return made;
}

}  // namespace spindle_twin::fem_offline
