#include "fem_offline/look/picture_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace spindle_twin::fem_offline {
namespace {

constexpr double margin_left_px = 100.0, margin_right_px = 60.0, top_px = 140.0;
constexpr double most_height_px = 950.0;
constexpr double line_height_px = 25.0, group_title_px = 34.0;
constexpr double legend_left_px = 60.0;

}  // namespace

View make_view(const std::vector<Point>& nodes, Geometry geometry) {
  Box box{1e9, -1e9, 1e9, -1e9};
  for (const Point& node : nodes) {
    box.r0_m = std::min(box.r0_m, node.r_m);
    box.r1_m = std::max(box.r1_m, node.r_m);
    box.z0_m = std::min(box.z0_m, node.z_m);
    box.z1_m = std::max(box.z1_m, node.z_m);
  }
  const bool axis_is_near = geometry == Geometry::axisymmetric && box.r0_m >= 0.0 && box.r0_m <= box.r1_m - box.r0_m;
  // Room for arrows and supports around the section, none below an axis of rotation.
  constexpr double beside_px = 70.0, above_px = 50.0;
  const double below_px = axis_is_near ? 0.0 : above_px;
  const double r0_m = axis_is_near ? 0.0 : box.r0_m;
  const double room_px = picture_width_px - margin_left_px - margin_right_px;
  View view;
  view.geometry = geometry;
  view.px_per_m = std::min((room_px - 2.0 * beside_px) / (box.z1_m - box.z0_m),
                           (most_height_px - above_px - below_px) / (box.r1_m - r0_m));
  const double width_px = view.px_per_m * (box.z1_m - box.z0_m) + 2.0 * beside_px;
  const double height_px = view.px_per_m * (box.r1_m - r0_m) + above_px + below_px;
  const double left_px = margin_left_px + 0.5 * (room_px - width_px);
  view.frame = {left_px, top_px, left_px + width_px, top_px + height_px};
  view.z0_m = box.z0_m - beside_px / view.px_per_m;
  view.r0_m = r0_m - below_px / view.px_per_m;
  return view;
}

std::string section_words(const Spindle& spindle) {
  return spindle.geometry == Geometry::planar ? "planar section, values per metre of depth" : "meridian section";
}

void draw_title(Canvas& canvas, const std::string& title, const std::string& subtitle) {
  canvas.text({legend_left_px, 40}, title, {28.0, true, Align::left, ink});
  canvas.text({legend_left_px, 76}, subtitle, {19.0, false, Align::left, ink});
}

void trace(Canvas& canvas, const View& view, const OutlineFace& face) {
  const auto ring = [&](const Polygon& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Pixel at = view.at(points[i]);
      i == 0 ? cairo_move_to(canvas.pen(), at.x, at.y) : cairo_line_to(canvas.pen(), at.x, at.y);
    }
    cairo_close_path(canvas.pen());
  };
  ring(face.outer);
  for (const Polygon& hole : face.holes) ring(hole);
}

void fill_parts(Canvas& canvas, const View& view, const Section& section) {
  cairo_set_fill_rule(canvas.pen(), CAIRO_FILL_RULE_EVEN_ODD);
  for (std::size_t part = 0; part < section.outlines.size(); ++part) {
    for (const OutlineFace& face : section.outlines[part].faces) {
      trace(canvas, view, face);
      canvas.set_colour(part_colour(part));
      cairo_fill(canvas.pen());
    }
  }
}

void stroke_edges(Canvas& canvas, const View& view, const std::vector<Point>& nodes,
                  const std::vector<LatticeEdge>& edges, double width_px, const Colour& colour) {
  for (const auto& [a, b] : edges) {
    const Pixel from = view.at(nodes[a]), to = view.at(nodes[b]);
    cairo_move_to(canvas.pen(), from.x, from.y);
    cairo_line_to(canvas.pen(), to.x, to.y);
  }
  cairo_set_line_width(canvas.pen(), width_px);
  cairo_set_line_cap(canvas.pen(), CAIRO_LINE_CAP_ROUND);
  canvas.set_colour(colour);
  cairo_stroke(canvas.pen());
  cairo_set_line_cap(canvas.pen(), CAIRO_LINE_CAP_BUTT);
}

std::vector<double> FieldScale::levels() const {
  std::vector<double> found;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) found.push_back(k * step);
  return found;
}

int FieldScale::digits() const { return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9))); }

FieldScale make_scale(double least, double most) {
  // A field that is level but for rounding still needs a scale.
  const double least_span = 1e-6 * std::max({std::abs(least), std::abs(most), 1e-6});
  if (most - least < least_span) {
    least -= least_span;
    most += least_span;
  }
  constexpr int least_levels = 8;
  return {least, most, nice_step(most - least, least_levels)};
}

void fill_field(Canvas& canvas, const View& view, const std::vector<Point>& nodes,
                const std::vector<LatticeTriangle>& triangles, const Eigen::VectorXd& field, const FieldScale& scale) {
  std::array<std::uint32_t, 512> palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const Colour colour = field_colour(static_cast<double>(i) / static_cast<double>(palette.size() - 1));
    const auto byte = [](double share) { return static_cast<std::uint32_t>(std::lround(255.0 * share)); };
    palette[i] = byte(colour.red) << 16 | byte(colour.green) << 8 | byte(colour.blue);
  }
  cairo_surface_t* surface = cairo_get_target(canvas.pen());
  cairo_surface_flush(surface);
  unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  const double per_value = static_cast<double>(palette.size() - 1) / (scale.high - scale.low);
  for (const LatticeTriangle& triangle : triangles) {
    const Pixel a = view.at(nodes[triangle[0]]), b = view.at(nodes[triangle[1]]), c = view.at(nodes[triangle[2]]);
    const double twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (twice_area == 0.0) continue;
    const auto first = [](double low, int) { return std::max(0, static_cast<int>(std::ceil(low - 0.5))); };
    const auto last = [](double high, int count) {
      return std::min(count - 1, static_cast<int>(std::floor(high - 0.5)));
    };
    for (int y = first(std::min({a.y, b.y, c.y}), 0); y <= last(std::max({a.y, b.y, c.y}), canvas.height_px()); ++y) {
      auto* row = reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
      for (int x = first(std::min({a.x, b.x, c.x}), 0); x <= last(std::max({a.x, b.x, c.x}), canvas.width_px()); ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double to_b = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / twice_area;
        const double to_c = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / twice_area;
        constexpr double edge = -1e-9;
        if (to_b < edge || to_c < edge || to_b + to_c > 1.0 - edge) continue;
        const double value =
            (1.0 - to_b - to_c) * field[triangle[0]] + to_b * field[triangle[1]] + to_c * field[triangle[2]];
        const double place = std::clamp((value - scale.low) * per_value, 0.0, static_cast<double>(palette.size() - 1));
        row[x] = palette[static_cast<std::size_t>(place)];
      }
    }
  }
  cairo_surface_mark_dirty(surface);
}

void draw_colour_bar(Canvas& canvas, const PixelBox& box, const FieldScale& scale, const std::string& title) {
  const auto x_of = [&](double value) {
    return box.x0 + (box.x1 - box.x0) * (value - scale.low) / (scale.high - scale.low);
  };
  for (double x = box.x0; x < box.x1; x += 1.0) {
    canvas.fill_box({x, box.y0, std::min(x + 1.5, box.x1), box.y1}, field_colour((x - box.x0) / (box.x1 - box.x0)));
  }
  canvas.frame_box(box, 1.2, ink);
  for (const double level : scale.levels()) {
    canvas.line({x_of(level), box.y0}, {x_of(level), box.y1 + 6}, 1.2, ink);
    canvas.text({x_of(level), box.y1 + 19}, fixed(level, scale.digits()), {16.0, false, Align::centre, ink});
  }
  canvas.text({box.x0 - 16, 0.5 * (box.y0 + box.y1)}, title, {18.0, true, Align::right, ink});
}

int legend_height_px(const std::vector<LegendGroup>& groups, int columns) {
  double height_px = 20.0;
  for (const LegendGroup& group : groups) {
    if (group.lines.empty()) continue;
    const double rows = std::ceil(static_cast<double>(group.lines.size()) / columns);
    height_px += group_title_px + rows * line_height_px + 12.0;
  }
  return static_cast<int>(height_px);
}

void draw_legend(Canvas& canvas, double top, const std::vector<LegendGroup>& groups, int columns) {
  const double column_px = (canvas.width_px() - 2.0 * legend_left_px) / columns;
  double y = top;
  for (const LegendGroup& group : groups) {
    if (group.lines.empty()) continue;
    canvas.text({legend_left_px, y + 14}, group.title, {17.0, true, Align::left, ink});
    y += group_title_px;
    const std::size_t rows =
        (group.lines.size() + static_cast<std::size_t>(columns) - 1) / static_cast<std::size_t>(columns);
    for (std::size_t i = 0; i < group.lines.size(); ++i) {
      const LegendLine& line = group.lines[i];
      const std::size_t column = i / rows;
      const double x = legend_left_px + static_cast<double>(column) * column_px;
      const double middle = y + (static_cast<double>(i % rows) + 0.5) * line_height_px;
      double words_x = x;
      if (line.draw_symbol) {
        line.draw_symbol(canvas, {x, middle - 9, x + 34, middle + 9});
        words_x += 44;
      }
      canvas.text({words_x, middle}, line.words, {16.0, false, Align::left, ink});
      canvas.text({x + column_px - 40, middle}, line.value, {16.0, false, Align::right, ink});
    }
    y += static_cast<double>(rows) * line_height_px + 12.0;
  }
}

}  // namespace spindle_twin::fem_offline
