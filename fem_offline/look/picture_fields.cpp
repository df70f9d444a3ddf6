#include <algorithm>
#include <cmath>

#include "fem_offline/look/picture_frame.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double micrometres_per_metre = 1e6;
constexpr Colour rim_colour{0.1, 0.1, 0.12, 0.85};

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

void draw_isolines(Canvas& canvas, const View& view, const SectionPicture& picture,
                   const std::vector<LatticeTriangle>& triangles, const FieldScale& scale, LabelBoard& board) {
  constexpr double apart_px = 330.0;
  for (const double level : scale.levels()) {
    const std::vector<IsolinePiece> pieces = isoline(picture.lattice, triangles, picture.rises_K, level);
    for (const IsolinePiece& piece : pieces) {
      const Pixel from = view.at(piece.start), to = view.at(piece.end);
      cairo_move_to(canvas.pen(), from.x, from.y);
      cairo_line_to(canvas.pen(), to.x, to.y);
    }
    cairo_set_line_width(canvas.pen(), 1.1);
    canvas.set_colour({1.0, 1.0, 1.0, 0.9});
    cairo_stroke(canvas.pen());
    std::vector<Pixel> labelled;
    const TextStyle style{13.0, false, Align::centre, ink, true};
    const std::string words = fixed(level, scale.digits());
    const double half_px = 0.5 * canvas.text_width_px(words, style) + 3.0;
    for (const IsolinePiece& piece : pieces) {
      const Pixel at = view.at(piece.start);
      const PixelBox box{at.x - half_px, at.y - 8, at.x + half_px, at.y + 8};
      const bool is_near = std::any_of(labelled.begin(), labelled.end(), [&](const Pixel& other) {
        return std::hypot(other.x - at.x, other.y - at.y) < apart_px;
      });
      if (is_near || !board.is_free(box)) continue;
      board.keep_free(box);
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

PixelBox bar_box(const View& view) { return {480, view.frame.y1 + 78, picture_width_px - 100, view.frame.y1 + 100}; }
constexpr double below_section_px = 150.0;

}  // namespace

void draw_rise_picture(const SectionPicture& picture, const std::string& path) {
  const View view = make_view(picture.lattice);
  const std::vector<Extremes> extremes = extremes_of(picture, picture.rises_K);
  std::vector<LegendGroup> groups{{"Rise in K: least to greatest of every part", {}}};
  for (std::size_t part = 0; part < extremes.size(); ++part) {
    groups[0].lines.push_back({{},
                               picture.spindle.parts[part].name,
                               fixed(picture.rises_K[extremes[part].least_node], 2) + " to " +
                                   fixed(picture.rises_K[extremes[part].most_node], 2)});
  }
  if (!picture.air_rises_K.empty()) {
    groups.push_back({"Rise of enclosed air in K", {}});
    for (const NamedValue& air : picture.air_rises_K) groups[1].lines.push_back({{}, air.name, fixed(air.value, 2)});
  }
  const double legend_top = view.frame.y1 + below_section_px;
  Canvas canvas(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, 4));
  draw_title(canvas, picture.spindle.name + ": temperature rise", picture.state.title);

  const std::vector<LatticeTriangle> triangles = triangles_of(picture.lattice);
  const FieldScale scale = make_scale(picture.rises_K.minCoeff(), picture.rises_K.maxCoeff());
  fill_field(canvas, view, picture.lattice.nodes, triangles, picture.rises_K, scale);
  stroke_edges(canvas, view, picture.lattice.nodes, edges_of(picture.lattice, true), 1.3, rim_colour);
  draw_axes(canvas, view);

  // The hottest place of every part that carries a source, the hottest of all first so that it gets the best place.
  LabelBoard board(canvas, {view.frame.x0, 95, view.frame.x1, view.frame.y1});
  std::vector<std::size_t> heated;
  for (const HeatSource& heat : picture.spindle.heats) {
    for (const HeatShare& share : heat.shares) heated.push_back(share.part);
  }
  const auto most = [&](std::size_t part) { return picture.rises_K[extremes[part].most_node]; };
  for (std::size_t part = 0; part < extremes.size(); ++part) {
    if (most(part) == scale.high) heated.push_back(part);
  }
  std::sort(heated.begin(), heated.end());
  heated.erase(std::unique(heated.begin(), heated.end()), heated.end());
  std::sort(heated.begin(), heated.end(), [&](std::size_t a, std::size_t b) { return most(a) > most(b); });
  const auto place_of = [&](std::size_t part) { return view.at(picture.lattice.nodes[extremes[part].most_node]); };
  for (const std::size_t part : heated) {
    const Pixel at = place_of(part);
    mark_extreme(canvas, at);
    board.keep_free({at.x - 7, at.y - 7, at.x + 7, at.y + 7});
  }
  for (std::size_t i = 0; i < heated.size(); ++i) {
    board.add(place_of(heated[i]), picture.spindle.parts[heated[i]].name + " " + fixed(most(heated[i]), 2) + " K",
              {i == 0 ? 19.0 : 15.0, i == 0, Align::centre, ink, true});
  }
  draw_isolines(canvas, view, picture, triangles, scale, board);
  board.draw();
  draw_colour_bar(canvas, bar_box(view), scale, "rise in K above " + fixed(picture.state.datum_K - 273.15, 2) + " °C");
  draw_legend(canvas, legend_top, groups, 4);
  canvas.save(path);
}

void draw_deformed_picture(const SectionPicture& picture, const std::string& path) {
  const View view = make_view(picture.lattice);
  const auto count = static_cast<Eigen::Index>(picture.lattice.nodes.size());
  const auto by_node = picture.displacements_m.reshaped(2, count);
  const Eigen::VectorXd length_um = micrometres_per_metre * by_node.colwise().norm().transpose();
  // The longest displacement is drawn about as long as a twentieth of the section's height.
  const double most_m = std::max(length_um.maxCoeff() / micrometres_per_metre, 1e-15);
  const double drawn_m = 0.055 * (view.frame.y1 - view.frame.y0) / view.px_per_m;
  const double exaggeration = nice_step(drawn_m / most_m, 1);
  std::vector<Point> moved = picture.lattice.nodes;
  for (Eigen::Index i = 0; i < count; ++i) {
    moved[static_cast<std::size_t>(i)].r_m += exaggeration * by_node(0, i);
    moved[static_cast<std::size_t>(i)].z_m += exaggeration * by_node(1, i);
  }

  std::vector<LegendGroup> groups{{"Deformation in µm", {}}};
  for (std::size_t i = 0; i < picture.deformation_um.size(); ++i) {
    groups[0].lines.push_back({{}, picture.spindle.deformations[i].name, fixed(picture.deformation_um[i], 3)});
  }
  const auto range = [&](int component, const std::string& name) {
    groups[0].lines.push_back({{},
                               name,
                               fixed(micrometres_per_metre * by_node.row(component).minCoeff(), 2) + " to " +
                                   fixed(micrometres_per_metre * by_node.row(component).maxCoeff(), 2)});
  };
  range(0, "u_r of all parts");
  range(1, "u_z of all parts");
  const double legend_top = view.frame.y1 + below_section_px;
  Canvas canvas(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, 4));
  const std::string times = fixed(exaggeration, 0);
  draw_title(canvas, picture.spindle.name + ": deformed shape, exaggerated " + times + " times",
             picture.state.title + "; growth from the stress-free state at " +
                 fixed(picture.spindle.operating.reference_temperature_K - 273.15, 2) + " °C; dashed red: undeformed");
  const FieldScale scale = make_scale(length_um.minCoeff(), length_um.maxCoeff());
  fill_field(canvas, view, moved, triangles_of(picture.lattice), length_um, scale);
  const std::vector<LatticeEdge> rim = edges_of(picture.lattice, true);
  stroke_edges(canvas, view, moved, rim, 1.3, rim_colour);
  const std::vector<double> dashes{4.0, 4.0};
  cairo_set_dash(canvas.pen(), dashes.data(), 2, 0.0);
  stroke_edges(canvas, view, picture.lattice.nodes, rim, 1.2, {0.75, 0.1, 0.1, 0.75});
  cairo_set_dash(canvas.pen(), nullptr, 0, 0.0);
  draw_axes(canvas, view);

  LabelBoard board(canvas, {view.frame.x0, 95, picture_width_px - 20, view.frame.y1});
  for (std::size_t i = 0; i < picture.deformation_um.size(); ++i) {
    const DeformationOutput& output = picture.spindle.deformations[i];
    const Pixel at =
        view.at({0.5 * (output.face.r0_m + output.face.r1_m), 0.5 * (output.face.z0_m + output.face.z1_m)});
    const char axis = output.direction == Direction::radial ? 'r' : 'z';
    board.add(
        at,
        output.name + " " + fixed(picture.deformation_um[i], 2) + " µm along " + (output.sign < 0 ? "−" : "+") + axis,
        {19.0, true, Align::centre, ink, true});
    canvas.disc(at, 5.0, ink, {1.0, 1.0, 1.0, 1.0});
  }
  board.draw();
  draw_colour_bar(canvas, bar_box(view), scale, "displacement in µm");
  draw_legend(canvas, legend_top, groups, 3);
  canvas.save(path);
}

void draw_mesh_picture(const SectionPicture& picture, const std::string& path) {
  const View view = make_view(picture.lattice);
  std::vector<std::size_t> elements(picture.spindle.parts.size(), 0);
  for (const LatticeCell& cell : picture.lattice.cells) ++elements[cell.part];
  std::vector<LegendGroup> groups{{"Elements of every part", {}}};
  for (std::size_t part = 0; part < elements.size(); ++part) {
    groups[0].lines.push_back({[part](Canvas& canvas, const PixelBox& box) {
                                 canvas.fill_box(box, part_colour(part));
                                 canvas.frame_box(box, 1.0, ink);
                               },
                               picture.spindle.parts[part].name, std::to_string(elements[part])});
  }
  const double legend_top = view.frame.y1 + 75.0;
  Canvas canvas(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, 4));
  draw_title(canvas, picture.spindle.name + ": mesh",
             std::to_string(picture.lattice.cells.size()) + " quadrilaterals of degree " +
                 std::to_string(picture.lattice.degree) + ", " + std::to_string(picture.lattice.nodes.size()) +
                 " nodes, element size " + fixed(1e3 * picture.spindle.mesh.element_size_m, 2) +
                 " mm; parts share no nodes");
  fill_parts(canvas, view, picture.section);
  stroke_edges(canvas, view, picture.lattice.nodes, edges_of(picture.lattice, false), 0.8, {0.2, 0.25, 0.35, 0.9});
  stroke_edges(canvas, view, picture.lattice.nodes, edges_of(picture.lattice, true), 2.0, ink);
  draw_axes(canvas, view);
  draw_legend(canvas, legend_top, groups, 4);
  canvas.save(path);
}

}  // namespace spindle_twin::fem_offline
