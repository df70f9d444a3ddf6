#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fem_offline/look/picture.hpp"
#include "fem_offline/look/picture_canvas.hpp"

/// What the figures of the section have in common.
namespace spindle_twin::fem_offline {

inline constexpr int picture_width_px = 2000;
inline constexpr Colour ink{0.12, 0.12, 0.14, 1.0};

/// The whole section with a margin, below a title; the axis of rotation is in view unless it is far off.
View make_view(const Lattice& lattice);

void draw_title(Canvas& canvas, const std::string& title, const std::string& subtitle);

/// The path of a face with its holes, for filling by the even-odd rule or clipping.
void trace(Canvas& canvas, const View& view, const OutlineFace& face);

/// All parts in their pale colours.
void fill_parts(Canvas& canvas, const View& view, const Section& section);

void stroke_edges(Canvas& canvas, const View& view, const std::vector<Point>& nodes,
                  const std::vector<LatticeEdge>& edges, double width_px, const Colour& colour);

/// Colours from `low` to `high`.
struct FieldScale {
  double low = 0.0;
  double high = 1.0;
  double step = 0.1;  ///< between marked levels
  std::vector<double> levels() const;
  int digits() const;
};
FieldScale make_scale(double least, double most);

/// Every pixel whose centre lies in a triangle takes the colour of the field there.
void fill_field(Canvas& canvas, const View& view, const std::vector<Point>& nodes,
                const std::vector<LatticeTriangle>& triangles, const Eigen::VectorXd& field, const FieldScale& scale);

void draw_colour_bar(Canvas& canvas, const PixelBox& box, const FieldScale& scale, const std::string& title);

/// One line of a legend or table; `draw_symbol` gets a box of 34 x 18 pixels.
struct LegendLine {
  std::function<void(Canvas&, const PixelBox&)> draw_symbol;
  std::string words;
  std::string value;  ///< right-aligned
};
struct LegendGroup {
  std::string title;
  std::vector<LegendLine> lines;
};

/// Height of the groups below each other, each in `columns` columns.
int legend_height_px(const std::vector<LegendGroup>& groups, int columns);
void draw_legend(Canvas& canvas, double top_px, const std::vector<LegendGroup>& groups, int columns);

void draw_parts_picture(const SectionPicture& picture, const std::string& path);
void draw_rise_picture(const SectionPicture& picture, const std::string& path);
void draw_deformed_picture(const SectionPicture& picture, const std::string& path);
void draw_mesh_picture(const SectionPicture& picture, const std::string& path);

}  // namespace spindle_twin::fem_offline
