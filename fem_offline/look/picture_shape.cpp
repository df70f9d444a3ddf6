#include <algorithm>
#include <cmath>
#include <limits>

#include "fem_offline/look/picture_frame.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double millimetres_per_metre = 1e3;

/// The node of the part that is nearest to a place.
std::size_t nearest_node(const Lattice& lattice, std::size_t part, const Point& place) {
  std::size_t nearest = 0;
  double least_m = std::numeric_limits<double>::max();
  for (const LatticeCell& cell : lattice.cells) {
    if (cell.part != part) continue;
    for (const int node : cell.nodes) {
      const Point& at = lattice.nodes[static_cast<std::size_t>(node)];
      const double distance_m = std::hypot(at.r_m - place.r_m, at.z_m - place.z_m);
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      nearest = static_cast<std::size_t>(node);
    }
  }
  return nearest;
}

}  // namespace

void draw_deformed_picture(const SectionPicture& picture, const std::string& path) {
  View view = make_view(picture.lattice.nodes, picture.spindle.geometry);
  const auto count = static_cast<Eigen::Index>(picture.lattice.nodes.size());
  const auto by_node = picture.displacements_m.reshaped(2, count);
  const Eigen::VectorXd length_um = rom::um_per_m * by_node.colwise().norm().transpose();
  // The longest displacement is drawn about as long as a twentieth of the section's height.
  const double most_m = std::max(length_um.maxCoeff() / rom::um_per_m, 1e-15);
  const double drawn_m = 0.055 * (view.frame.y1 - view.frame.y0) / view.px_per_m;
  const double exaggeration = nice_step(drawn_m / most_m, 1);
  std::vector<Point> moved = picture.lattice.nodes;
  for (Eigen::Index i = 0; i < count; ++i) {
    moved[static_cast<std::size_t>(i)].r_m += exaggeration * by_node(0, i);
    moved[static_cast<std::size_t>(i)].z_m += exaggeration * by_node(1, i);
  }

  std::vector<Point> both = picture.lattice.nodes;
  both.insert(both.end(), moved.begin(), moved.end());
  view = make_view(both, picture.spindle.geometry);

  std::vector<LegendGroup> groups{{"Deformation in µm", {}}};
  for (std::size_t i = 0; i < picture.deformation_um.size(); ++i) {
    const DeformationOutput& output = picture.spindle.deformations[i];
    const std::string less = output.minus ? " less " + picture.spindle.deformations[*output.minus].name : "";
    groups[0].lines.push_back(
        {{}, output.name + " along " + sense_of(output, view) + less, fixed(picture.deformation_um[i], 3)});
  }
  const auto range = [&](int component, const std::string& name) {
    groups[0].lines.push_back({{},
                               name,
                               fixed(rom::um_per_m * by_node.row(component).minCoeff(), 2) + " to " +
                                   fixed(rom::um_per_m * by_node.row(component).maxCoeff(), 2)});
  };
  range(0, std::string("u_") + view.name_up() + " of all parts");
  range(1, std::string("u_") + view.name_right() + " of all parts");
  const double legend_top = view.frame.y1 + below_section_px;
  Canvas canvas(picture_width_px, static_cast<int>(legend_top) + legend_height_px(groups, 4));
  const std::string times = fixed(exaggeration, 0);
  draw_title(canvas, picture.spindle.name + ": deformed shape, exaggerated " + times + " times",
             picture.state.title + "; growth from the stress-free state at " +
                 fixed(picture.spindle.operating.reference_temperature_K - rom::zero_degC_K, 2) +
                 " °C; dashed red: undeformed");
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
  std::vector<Pixel> tips;
  for (const DeformationOutput& output : picture.spindle.deformations) {
    const Pixel at = view.at(moved[nearest_node(picture.lattice, output.part, anchor_of(output))]);
    tips.push_back(draw_output_arrow(canvas, at, output, board));
    canvas.disc(at, 5.0, ink, {1.0, 1.0, 1.0, 1.0});
  }
  for (std::size_t i = 0; i < picture.deformation_um.size(); ++i) {
    const DeformationOutput& output = picture.spindle.deformations[i];
    board.add(tips[i], output.name + " " + fixed(picture.deformation_um[i], 2) + " µm along " + sense_of(output, view),
              {17.0, true, Align::centre, ink, true});
  }
  board.draw();
  draw_colour_bar(canvas, bar_box(view), scale, "displacement in µm");
  draw_legend(canvas, legend_top, groups, 3);
  canvas.save(path);
}

void draw_mesh_picture(const SectionPicture& picture, const std::string& path) {
  const View view = make_view(picture.lattice.nodes, picture.spindle.geometry);
  std::vector<LegendGroup> groups{
      {"Elements of every part, their sides in mm, least scaled Jacobian (1: rectangles)", {}}};
  for (std::size_t part = 0; part < picture.quality.size(); ++part) {
    const PartQuality& quality = picture.quality[part];
    groups[0].lines.push_back(
        {[part](Canvas& canvas, const PixelBox& box) {
           canvas.fill_box(box, part_colour(part));
           canvas.frame_box(box, 1.0, ink);
         },
         quality.part,
         std::to_string(quality.cells) + ", " + compact(millimetres_per_metre * quality.least_side_m) + " to " +
             compact(millimetres_per_metre * quality.longest_side_m) + ", " + fixed(quality.least_scaled_jacobian, 2)});
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
