#pragma once

#include <cairo.h>

#include <memory>
#include <string>
#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "fem_offline/look/picture_colours.hpp"

namespace spindle_twin::fem_offline {

/// A place on the picture in pixels, y downwards.
struct Pixel {
  double x = 0.0;
  double y = 0.0;
};

struct PixelBox {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
};

enum class Align { left, centre, right };

struct TextStyle {
  double size_px = 17.0;
  bool bold = false;
  Align align = Align::left;
  Colour colour{0.1, 0.1, 0.12, 1.0};
  bool halo = false;  ///< white rim, for text on a field
};

inline constexpr Colour ink{0.12, 0.12, 0.14, 1.0};

/// A PNG in the making. Text stands vertically centred on its place.
class Canvas {
 public:
  Canvas(int width_px, int height_px);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  cairo_t* pen() { return pen_; }
  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

  void set_colour(const Colour& colour);
  void line(const Pixel& from, const Pixel& to, double width_px, const Colour& colour,
            const std::vector<double>& dashes_px = {});
  void fill_box(const PixelBox& box, const Colour& colour);
  void frame_box(const PixelBox& box, double width_px, const Colour& colour);
  /// Longer than a round one by `stretch_px` on both sides.
  void disc(const Pixel& at, double radius_px, const Colour& fill, const Colour& rim, double stretch_px = 0.0);
  /// Head at `to`.
  void arrow(const Pixel& from, const Pixel& to, const Colour& colour);
  void polygon(const std::vector<Pixel>& corners, const Colour& fill, const Colour& rim);
  void text(const Pixel& at, const std::string& words, const TextStyle& style = {});
  double text_width_px(const std::string& words, const TextStyle& style = {});
  /// What the letters of a text at that place cover, with their rim.
  PixelBox text_box(const Pixel& at, const std::string& words, const TextStyle& style = {});
  /// The boxes of all texts on the canvas so far.
  const std::vector<PixelBox>& texts() const { return texts_; }

  /// Throws rom::InputError if the file cannot be written.
  void save(const std::string& path);

 private:
  void set_font(const TextStyle& style);
  /// Where the first letter begins, on the base line.
  Pixel start_of(const Pixel& at, const std::string& words, const TextStyle& style);

  int width_px_;
  int height_px_;
  cairo_surface_t* surface_;
  cairo_t* pen_;
  std::vector<PixelBox> texts_;
};

/// Where the section lies on the picture: z to the right, r upwards; y and x of a planar one.
struct View {
  Geometry geometry = Geometry::axisymmetric;
  PixelBox frame;
  double px_per_m = 1.0;
  double z0_m = 0.0;
  double r0_m = 0.0;

  double x(double z_m) const { return frame.x0 + px_per_m * (z_m - z0_m); }
  double y(double r_m) const { return frame.y1 - px_per_m * (r_m - r0_m); }
  Pixel at(const Point& point) const { return {x(point.z_m), y(point.r_m)}; }
  /// Of the axis that runs upwards and the one that runs to the right.
  char name_up() const { return geometry == Geometry::planar ? 'x' : 'r'; }
  char name_right() const { return geometry == Geometry::planar ? 'y' : 'z'; }
};

/// Axes in mm, and the axis of rotation as a chain line if there is one and it is in view.
void draw_axes(Canvas& canvas, const View& view);

/// A number with three significant digits, as short as it goes: 5.2e+10, 0.03, 1500.
std::string compact(double value);

/// A number with `digits` behind the point, without a minus before zero.
std::string fixed(double value, int digits);

}  // namespace spindle_twin::fem_offline
