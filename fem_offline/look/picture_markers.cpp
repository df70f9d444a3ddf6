#include <algorithm>
#include <cmath>

#include "fem_offline/look/picture_frame.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr Colour black{0.0, 0.0, 0.0, 1.0};
constexpr Colour probe_colour{0.75, 0.88, 1.0, 1.0};
const TextStyle label_style{17.0, true, Align::centre, ink, true};

/// Drawn as fixed ground: a thick line with oblique strokes on the outside.
void draw_ground(Canvas& canvas, const Pixel& from, const Pixel& to, const Pixel& normal) {
  canvas.line(from, to, 4.0, ink);
  const double length_px = std::hypot(to.x - from.x, to.y - from.y);
  if (length_px <= 0.0) return;
  const int strokes = std::max(2, static_cast<int>(length_px / 8.0));
  const double ux = (to.x - from.x) / length_px, uy = (to.y - from.y) / length_px;
  for (int i = 0; i <= strokes; ++i) {
    const double along_px = length_px * i / strokes;
    const Pixel root{from.x + along_px * ux, from.y + along_px * uy};
    canvas.line(root, {root.x + 11.0 * normal.x + 7.0 * ux, root.y + 11.0 * normal.y + 7.0 * uy}, 1.8, ink);
  }
}

/// A triangle that stands on ground, its tip at the held point.
void draw_bearing(Canvas& canvas, const Pixel& at, const Pixel& away) {
  constexpr double length_px = 16.0, half_px = 10.0;
  const Pixel base{at.x + length_px * away.x, at.y + length_px * away.y};
  const Pixel a{base.x - half_px * away.y, base.y + half_px * away.x};
  const Pixel b{base.x + half_px * away.y, base.y - half_px * away.x};
  canvas.polygon({at, a, b}, white, ink);
  draw_ground(canvas, a, b, away);
}

/// A zigzag from the body to ground.
void draw_spring(Canvas& canvas, const Pixel& at, const Pixel& away) {
  constexpr double pitch_px = 5.0, half_px = 7.0;
  constexpr int turns = 6;
  const auto place = [&](double along_px, double aside_px) {
    return Pixel{at.x + along_px * away.x - aside_px * away.y, at.y + along_px * away.y + aside_px * away.x};
  };
  Pixel last = at;
  for (int i = 1; i <= turns; ++i) {
    const Pixel next = place(pitch_px * i, i == turns ? 0.0 : (i % 2 == 0 ? half_px : -half_px));
    canvas.line(last, next, 2.2, ink);
    last = next;
  }
  draw_ground(canvas, place(pitch_px * turns + 1.0, -14.0), place(pitch_px * turns + 1.0, 14.0), away);
}

bool holds(const Support& support, Hold hold) { return support.hold_r == hold || support.hold_z == hold; }

/// Such as "holds r z" or "spring z 1.5e+08 N/m".
std::string support_words(const Support& support, const View& view) {
  const std::string up(1, view.name_up()), right(1, view.name_right());
  std::string words;
  const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
  if (holds(support, Hold::fixed)) {
    add("holds" + (support.hold_r == Hold::fixed ? " " + up : "") + (support.hold_z == Hold::fixed ? " " + right : ""));
  }
  const auto spring = [&](const std::string& axis, double stiffness_N_per_m) {
    add("spring ");
    words += axis + " ";
    words += compact(stiffness_N_per_m) + " N/m";
  };
  if (support.hold_r == Hold::spring) spring(up, support.stiffness_r_N_per_m);
  if (support.hold_z == Hold::spring) spring(right, support.stiffness_z_N_per_m);
  if (holds(support, Hold::plane)) add("stays plane");
  return words;
}

/// Direction away from the part at a point of its outline: mean of the outward normals that meet there.
Pixel away_from_part(const SectionPicture& picture, std::size_t part, const Point& at) {
  Pixel sum{0.0, 0.0};
  for (const BoundaryPiece& piece : picture.section.pieces) {
    if (piece.part != part) continue;
    for (const Point& end : {piece.start, piece.end}) {
      constexpr double near_m = 1e-8;
      if (std::hypot(end.r_m - at.r_m, end.z_m - at.z_m) > near_m) continue;
      const Pixel normal = outward(piece);
      sum = {sum.x + normal.x, sum.y + normal.y};
    }
  }
  return sum;
}

/// At its place, its symbol: a bearing for what is held at a point, ground along what is held on a face, springs.
void draw_support(Canvas& canvas, const View& view, const SectionPicture& picture, const Support& support,
                  LabelBoard& board) {
  const std::string words = support_words(support, view);
  Pixel middle{}, normal{};
  if (support.is_point()) {
    const Point at{support.face.r0_m, support.face.z0_m};
    middle = view.at(at);
    normal = away_from_part(picture, support.part, at);
  } else {
    double longest_px = 0.0;
    for (const BoundaryPiece& piece : picture.section.pieces) {
      if (piece.part != support.part || !lies_in(piece, support.face)) continue;
      const Pixel from = view.at(piece.start), to = view.at(piece.end), out = outward(piece);
      if (holds(support, Hold::fixed)) draw_ground(canvas, from, to, out);
      if (holds(support, Hold::plane)) draw_piece(canvas, view, piece, {7.0, 4.0, ink, {14, 4, 3, 4}});
      board.keep_free({std::min(from.x, to.x) - 12, std::min(from.y, to.y) - 12, std::max(from.x, to.x) + 12,
                       std::max(from.y, to.y) + 12});
      const double length_px = std::hypot(to.x - from.x, to.y - from.y);
      if (length_px < longest_px) continue;
      longest_px = length_px;
      middle = {0.5 * (from.x + to.x), 0.5 * (from.y + to.y)};
      normal = out;
    }
    if (longest_px == 0.0) return;
  }
  // Along its own axis, on the side away from the part.
  const Pixel along_r{0.0, normal.y > 0.0 ? 1.0 : -1.0}, along_z{normal.x < 0.0 ? -1.0 : 1.0, 0.0};
  const auto draw_one = [&](Hold hold, const Pixel& away) {
    if (hold == Hold::spring) draw_spring(canvas, middle, away);
    if (hold == Hold::fixed && support.is_point()) draw_bearing(canvas, middle, away);
  };
  draw_one(support.hold_r, along_r);
  draw_one(support.hold_z, along_z);
  const double length_px = std::max(std::hypot(normal.x, normal.y), 1e-9);
  const bool is_long = support.is_point() || holds(support, Hold::spring);
  const double reach_px = is_long ? 44.0 : 14.0;
  board.keep_free({middle.x - reach_px, middle.y - reach_px, middle.x + reach_px, middle.y + reach_px});
  constexpr double from_px = 14.0;
  board.add(box_of({middle.x + from_px * normal.x / length_px, middle.y + from_px * normal.y / length_px}), words,
            label_style);
}

}  // namespace

std::string letter_of(std::size_t index) {
  constexpr std::size_t letters = 26;
  std::string name(1, static_cast<char>('A' + index % letters));
  if (index >= letters) name += std::to_string(index / letters);
  return name;
}

void add_key_points(const View& view, const Spindle& spindle, LabelBoard& board) {
  for (std::size_t k = 0; k < spindle.key_points.size(); ++k) {
    board.add_disc(view.at(spindle.key_points[k].at), letter_of(k));
  }
}

Point anchor_of(const DeformationOutput& output) {
  if (output.at) return *output.at;
  return {0.5 * (output.face.r0_m + output.face.r1_m), 0.5 * (output.face.z0_m + output.face.z1_m)};
}

Pixel draw_output_arrow(Canvas& canvas, const Pixel& anchor, const DeformationOutput& output, LabelBoard& board) {
  constexpr double length_px = 46.0;
  const bool is_radial = output.direction == Direction::radial;
  const Pixel tip{anchor.x + (is_radial ? 0.0 : output.sign * length_px),
                  anchor.y - (is_radial ? output.sign * length_px : 0.0)};
  canvas.arrow(anchor, tip, black);
  board.keep_free({std::min(anchor.x, tip.x) - 6, std::min(anchor.y, tip.y) - 6, std::max(anchor.x, tip.x) + 6,
                   std::max(anchor.y, tip.y) + 6});
  return tip;
}

std::string sense_of(const DeformationOutput& output, const View& view) {
  return (output.sign < 0 ? "−" : "+") +
         std::string(1, output.direction == Direction::radial ? view.name_up() : view.name_right());
}

void draw_supports(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  for (const Support& support : picture.spindle.supports) draw_support(canvas, view, picture, support, board);
}

void draw_outputs(Canvas& canvas, const View& view, const SectionPicture& picture, LabelBoard& board) {
  std::vector<Pixel> tips;
  for (const DeformationOutput& output : picture.spindle.deformations) {
    if (!output.at) {
      for (const BoundaryPiece& piece : picture.section.pieces) {
        if (piece.part != output.part || !lies_in(piece, output.face)) continue;
        draw_piece(canvas, view, piece, {0.0, 6.0, black});
      }
    }
    const Pixel anchor = view.at(anchor_of(output));
    if (output.at) canvas.disc(anchor, 5.0, black, white);
    tips.push_back(draw_output_arrow(canvas, anchor, output, board));
  }
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const DeformationOutput& output = picture.spindle.deformations[i];
    std::string words = output.name;
    if (output.minus) words += " less " + picture.spindle.deformations[*output.minus].name;
    board.add(box_of(tips[i]), words, label_style);
  }
  for (const StressProbe& probe : picture.spindle.stress_probes) {
    const Pixel at = view.at(probe.at);
    canvas.polygon({{at.x, at.y - 8}, {at.x + 8, at.y}, {at.x, at.y + 8}, {at.x - 8, at.y}}, probe_colour, ink);
    board.keep_free({at.x - 9, at.y - 9, at.x + 9, at.y + 9});
    board.add({at.x - 9, at.y - 9, at.x + 9, at.y + 9}, probe.name, label_style);
  }
}

LegendGroup points_legend(const Spindle& spindle) {
  constexpr double millimetres_per_metre = 1e3;
  LegendGroup group{spindle.geometry == Geometry::planar ? "Key points, x and y in mm" : "Key points, r and z in mm",
                    {}};
  for (std::size_t k = 0; k < spindle.key_points.size(); ++k) {
    const KeyPoint& point = spindle.key_points[k];
    group.lines.push_back(
        {[k](Canvas& canvas, const PixelBox& box) {
           draw_letter_disc(canvas, {0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)}, letter_of(k));
         },
         point.name + " on " + spindle.parts[point.part].name,
         fixed(millimetres_per_metre * point.at.r_m, 1) + "; " + fixed(millimetres_per_metre * point.at.z_m, 1)});
  }
  return group;
}

LegendGroup supports_legend(const Spindle& spindle) {
  LegendGroup group{"Supports and outputs", {}};
  const auto any = [&](auto condition) {
    return std::any_of(spindle.supports.begin(), spindle.supports.end(), condition);
  };
  if (any([](const Support& support) { return !support.is_point() && holds(support, Hold::fixed); })) {
    group.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             draw_ground(canvas, {box.x0, box.y0 + 4}, {box.x1 - 6, box.y0 + 4}, {0.0, 1.0});
                           },
                           "held face", ""});
  }
  if (any([](const Support& support) { return support.is_point() && holds(support, Hold::fixed); })) {
    group.lines.push_back(
        {[](Canvas& canvas, const PixelBox& box) {
           canvas.polygon({{0.5 * (box.x0 + box.x1), box.y0}, {box.x0 + 8, box.y1}, {box.x1 - 8, box.y1}}, white, ink);
         },
         "held point", ""});
  }
  if (any([](const Support& support) { return holds(support, Hold::spring); })) {
    group.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             for (double x = box.x0; x + 8 < box.x1; x += 8) {
                               canvas.line({x, box.y1 - 2}, {x + 4, box.y0 + 2}, 2.2, ink);
                               canvas.line({x + 4, box.y0 + 2}, {x + 8, box.y1 - 2}, 2.2, ink);
                             }
                           },
                           "spring to the ground", ""});
  }
  if (any([](const Support& support) { return holds(support, Hold::plane); })) {
    group.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             const double y = 0.5 * (box.y0 + box.y1);
                             canvas.line({box.x0, y}, {box.x1, y}, 4.0, ink, {14, 4, 3, 4});
                           },
                           "face that stays plane", ""});
  }
  if (!spindle.deformations.empty()) {
    group.lines.push_back({[](Canvas& canvas, const PixelBox& box) {
                             const double y = 0.5 * (box.y0 + box.y1);
                             canvas.arrow({box.x1, y}, {box.x0, y}, black);
                           },
                           "deformation output, its positive sense", ""});
  }
  if (!spindle.stress_probes.empty()) {
    group.lines.push_back(
        {[](Canvas& canvas, const PixelBox& box) {
           const Pixel at{0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)};
           canvas.polygon({{at.x, at.y - 8}, {at.x + 8, at.y}, {at.x, at.y + 8}, {at.x - 8, at.y}}, probe_colour, ink);
         },
         "stress probe", ""});
  }
  return group;
}

}  // namespace spindle_twin::fem_offline
