#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fem_offline/look/picture.hpp"
#include "fem_offline/look/picture_canvas.hpp"
#include "fem_offline/look/picture_labels.hpp"

/// What the figures of the section have in common.
namespace spindle_twin::fem_offline {

inline constexpr int picture_width_px = 2000;

/// All nodes with a margin, below a title; the axis of rotation is in view unless it is far off.
View make_view(const std::vector<Point>& nodes, Geometry geometry);

/// "meridian section" or what a planar one is.
std::string section_words(const Spindle& spindle);

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

/// A, B, ... Z, A1, B1, ...: the mark of a key point or stress probe.
std::string letter_of(std::size_t index);

/// All key points as discs with their letters.
void add_key_points(const View& view, const Spindle& spindle, LabelBoard& board);

/// Where an output or its label belongs: its point, or the middle of its face.
Point anchor_of(const DeformationOutput& output);
/// From the anchor a fixed length along the positive sense of the output; returns the tip.
Pixel draw_output_arrow(Canvas& canvas, const Pixel& anchor, const DeformationOutput& output, LabelBoard& board);
/// Such as "+r", or "−y" of a planar section.
std::string sense_of(const DeformationOutput& output, const View& view);

/// Of the colour bar; the legend starts so far below the section when there is one.
inline PixelBox bar_box(const View& view) {
  return {480, view.frame.y1 + 78, picture_width_px - 100, view.frame.y1 + 100};
}
inline constexpr double below_section_px = 150.0;
inline constexpr Colour rim_colour{0.1, 0.1, 0.12, 0.85};

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

/// Height of the groups below each other, each in `columns` columns; a group without lines is left out.
int legend_height_px(const std::vector<LegendGroup>& groups, int columns);
void draw_legend(Canvas& canvas, double top_px, const std::vector<LegendGroup>& groups, int columns);

/// Unit normal out of the part, on the picture; the part lies to the left from start to end.
Pixel outward(const BoundaryPiece& piece);
/// How the line along a piece is drawn: so far outside the part, and in one stroke without dashes.
struct PieceLine {
  double offset_px = 0.0;
  double width_px = 1.0;
  Colour colour;
  std::vector<double> dashes_px{};
};
void draw_piece(Canvas& canvas, const View& view, const BoundaryPiece& piece, const PieceLine& line);

void draw_surfaces(Canvas& canvas, const View& view, const SectionPicture& picture);
LegendGroup surfaces_legend(const Spindle& spindle);
/// Arrows from segment to segment in the sense of the operating flow.
void draw_circuits(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board);
LegendGroup circuits_legend(const Spindle& spindle);
void draw_heats(Canvas& canvas, const View& view, const SectionPicture& picture);
LegendGroup heats_legend(const SectionPicture& picture);
void draw_supports(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board);
void draw_outputs(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board);
LegendGroup points_legend(const Spindle& spindle);
LegendGroup supports_legend(const Spindle& spindle);

std::unique_ptr<Canvas> draw_parts_picture(const SectionPicture& picture);
std::unique_ptr<Canvas> draw_rise_picture(const SectionPicture& picture);

}  // namespace spindle_twin::fem_offline
