#include "fem_offline/look/picture_canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "fem_offline/look/picture_lattice.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double millimetres_per_metre = 1e3;
constexpr double halo_share = 0.28;  // width of the pen that draws a rim, of the letters' size
constexpr Colour axis_colour{0.25, 0.25, 0.28, 1.0};

}  // namespace

Canvas::Canvas(int width_px, int height_px)
    : width_px_(width_px),
      height_px_(height_px),
      surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_px, height_px)),
      pen_(cairo_create(surface_)) {
  set_colour(white);
  cairo_paint(pen_);
  cairo_set_line_join(pen_, CAIRO_LINE_JOIN_ROUND);
}

Canvas::~Canvas() {
  cairo_destroy(pen_);
  cairo_surface_destroy(surface_);
}

void Canvas::set_colour(const Colour& colour) {
  cairo_set_source_rgba(pen_, colour.red, colour.green, colour.blue, colour.opacity);
}

void Canvas::line(const Pixel& from, const Pixel& to, double width_px, const Colour& colour,
                  const std::vector<double>& dashes_px) {
  cairo_set_dash(pen_, dashes_px.data(), static_cast<int>(dashes_px.size()), 0.0);
  cairo_set_line_width(pen_, width_px);
  cairo_move_to(pen_, from.x, from.y);
  cairo_line_to(pen_, to.x, to.y);
  set_colour(colour);
  cairo_stroke(pen_);
  cairo_set_dash(pen_, nullptr, 0, 0.0);
}

void Canvas::fill_box(const PixelBox& box, const Colour& colour) {
  cairo_rectangle(pen_, box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0);
  set_colour(colour);
  cairo_fill(pen_);
}

void Canvas::frame_box(const PixelBox& box, double width_px, const Colour& colour) {
  cairo_rectangle(pen_, box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0);
  cairo_set_line_width(pen_, width_px);
  set_colour(colour);
  cairo_stroke(pen_);
}

void Canvas::disc(const Pixel& at, double radius_px, const Colour& fill, const Colour& rim, double stretch_px) {
  constexpr double quarter = 0.5 * std::numbers::pi;
  cairo_new_path(pen_);
  cairo_arc(pen_, at.x + stretch_px, at.y, radius_px, -quarter, quarter);
  cairo_arc(pen_, at.x - stretch_px, at.y, radius_px, quarter, 3.0 * quarter);
  cairo_close_path(pen_);
  set_colour(fill);
  cairo_fill_preserve(pen_);
  cairo_set_line_width(pen_, 2.0);
  set_colour(rim);
  cairo_stroke(pen_);
}

void Canvas::arrow(const Pixel& from, const Pixel& to, const Colour& colour) {
  constexpr double head_px = 13.0, half_width_px = 6.0;
  const double length_px = std::hypot(to.x - from.x, to.y - from.y);
  if (length_px <= 0.0) return;
  const double ux = (to.x - from.x) / length_px, uy = (to.y - from.y) / length_px;
  const Pixel neck{to.x - head_px * ux, to.y - head_px * uy};
  line(from, neck, 3.0, colour);
  cairo_move_to(pen_, to.x, to.y);
  cairo_line_to(pen_, neck.x - half_width_px * uy, neck.y + half_width_px * ux);
  cairo_line_to(pen_, neck.x + half_width_px * uy, neck.y - half_width_px * ux);
  cairo_close_path(pen_);
  set_colour(colour);
  cairo_fill(pen_);
}

void Canvas::polygon(const std::vector<Pixel>& corners, const Colour& fill, const Colour& rim) {
  cairo_new_path(pen_);
  for (const Pixel& corner : corners) cairo_line_to(pen_, corner.x, corner.y);
  cairo_close_path(pen_);
  set_colour(fill);
  cairo_fill_preserve(pen_);
  cairo_set_line_width(pen_, 2.0);
  set_colour(rim);
  cairo_stroke(pen_);
}

void Canvas::set_font(const TextStyle& style) {
  cairo_select_font_face(pen_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(pen_, style.size_px);
}

double Canvas::text_width_px(const std::string& words, const TextStyle& style) {
  set_font(style);
  cairo_text_extents_t extents;
  cairo_text_extents(pen_, words.c_str(), &extents);
  return extents.x_advance;
}

Pixel Canvas::start_of(const Pixel& at, const std::string& words, const TextStyle& style) {
  const double shift = style.align == Align::left ? 0.0 : style.align == Align::centre ? 0.5 : 1.0;
  return {at.x - shift * text_width_px(words, style), at.y + 0.36 * style.size_px};
}

PixelBox Canvas::text_box(const Pixel& at, const std::string& words, const TextStyle& style) {
  const Pixel start = start_of(at, words, style);
  cairo_text_extents_t extents;
  cairo_text_extents(pen_, words.c_str(), &extents);
  const double rim_px = style.halo ? 0.5 * halo_share * style.size_px : 0.0;
  const double x = start.x + extents.x_bearing, y = start.y + extents.y_bearing;
  return {x - rim_px, y - rim_px, x + extents.width + rim_px, y + extents.height + rim_px};
}

void Canvas::text(const Pixel& at, const std::string& words, const TextStyle& style) {
  if (words.empty()) return;
  texts_.push_back(text_box(at, words, style));
  const Pixel start = start_of(at, words, style);
  if (style.halo) {
    cairo_move_to(pen_, start.x, start.y);
    cairo_text_path(pen_, words.c_str());
    cairo_set_line_width(pen_, halo_share * style.size_px);
    set_colour({1.0, 1.0, 1.0, 0.85});
    cairo_stroke(pen_);
  }
  cairo_move_to(pen_, start.x, start.y);
  set_colour(style.colour);
  cairo_show_text(pen_, words.c_str());
}

void Canvas::save(const std::string& path) {
  cairo_surface_flush(surface_);
  const cairo_status_t status = cairo_surface_write_to_png(surface_, path.c_str());
  if (status != CAIRO_STATUS_SUCCESS) {
    throw rom::InputError({path, 0}, "--png", std::string("cannot be written: ") + cairo_status_to_string(status));
  }
}

void draw_axes(Canvas& canvas, const View& view) {
  const PixelBox& frame = view.frame;
  canvas.line({frame.x0, frame.y1 + 8}, {frame.x1, frame.y1 + 8}, 1.5, axis_colour);
  canvas.line({frame.x0 - 8, frame.y0}, {frame.x0 - 8, frame.y1}, 1.5, axis_colour);
  const auto ticks = [&](double from_m, double to_m, double least_distance_px, auto draw) {
    const double from_mm = millimetres_per_metre * from_m, to_mm = millimetres_per_metre * to_m;
    const double px_per_mm = view.px_per_m / millimetres_per_metre;
    double step_mm = std::pow(10.0, std::floor(std::log10(least_distance_px / px_per_mm)));
    for (const double factor : {2.0, 2.5, 2.0}) {
      if (step_mm * px_per_mm < least_distance_px) step_mm *= factor;
    }
    const int digits = step_mm >= 1.0 ? 0 : static_cast<int>(std::ceil(-std::log10(step_mm) - 1e-9));
    for (double k = std::ceil(from_mm / step_mm - 1e-9); k * step_mm <= to_mm + 1e-9 * step_mm; k += 1.0) {
      draw(k * step_mm / millimetres_per_metre, fixed(k * step_mm, digits));
    }
  };
  const double right_m = view.z0_m + (frame.x1 - frame.x0) / view.px_per_m;
  const double top_m = view.r0_m + (frame.y1 - frame.y0) / view.px_per_m;
  const TextStyle tick_style{15.0, false, Align::centre, axis_colour};
  const double widest_px = std::max(canvas.text_width_px(fixed(millimetres_per_metre * view.z0_m, 0), tick_style),
                                    canvas.text_width_px(fixed(millimetres_per_metre * right_m, 0), tick_style));
  ticks(view.z0_m, right_m, std::max(50.0, widest_px + 22.0), [&](double z_m, const std::string& words) {
    canvas.line({view.x(z_m), frame.y1 + 8}, {view.x(z_m), frame.y1 + 15}, 1.5, axis_colour);
    canvas.text({view.x(z_m), frame.y1 + 27}, words, tick_style);
  });
  ticks(view.r0_m, top_m, 32.0, [&](double r_m, const std::string& words) {
    canvas.line({frame.x0 - 8, view.y(r_m)}, {frame.x0 - 15, view.y(r_m)}, 1.5, axis_colour);
    canvas.text({frame.x0 - 20, view.y(r_m)}, words, {15.0, false, Align::right, axis_colour});
  });
  canvas.text({0.5 * (frame.x0 + frame.x1), frame.y1 + 50}, std::string(1, view.name_right()) + " in mm",
              {16.0, false, Align::centre, axis_colour});
  canvas.text({frame.x0 - 20, frame.y0 - 22}, std::string(1, view.name_up()) + " in mm",
              {16.0, false, Align::centre, axis_colour});
  if (view.geometry == Geometry::axisymmetric && view.r0_m <= 0.0) {
    canvas.line({frame.x0, view.y(0.0)}, {frame.x1, view.y(0.0)}, 1.2, axis_colour, {24, 5, 4, 5});
  }
}

std::string compact(double value) {
  std::array<char, 32> buffer{};
  // Whole numbers in full up to a million.
  std::snprintf(buffer.data(), buffer.size(), std::abs(value) >= 1000.0 && std::abs(value) < 1e6 ? "%.0f" : "%.3g",
                value);
  return buffer.data();
}

std::string fixed(double value, int digits) {
  std::array<char, 64> buffer{};
  const double unit = std::pow(10.0, -digits);
  std::snprintf(buffer.data(), buffer.size(), "%.*f", digits, std::abs(value) < 0.5 * unit ? 0.0 : value);
  return buffer.data();
}

}  // namespace spindle_twin::fem_offline
