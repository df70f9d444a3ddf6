#include "fem_offline/look/picture_labels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace spindle_twin::fem_offline {
namespace {

constexpr double disc_radius_px = 9.0;
constexpr Colour disc_colour{1.0, 0.85, 0.1, 1.0};
const TextStyle disc_style{12.0, true, Align::centre, ink};

Pixel middle_of(const PixelBox& box) { return {0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)}; }

PixelBox grown(const PixelBox& box, double by_px) {
  return {box.x0 - by_px, box.y0 - by_px, box.x1 + by_px, box.y1 + by_px};
}

bool overlap(const PixelBox& a, const PixelBox& b) { return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1; }

Pixel nearest_in(const PixelBox& box, const Pixel& to) {
  return {std::clamp(to.x, box.x0, box.x1), std::clamp(to.y, box.y0, box.y1)};
}

/// Whether the line goes through the box; touching is not that.
bool crosses(const Leader& line, const PixelBox& box) {
  double first = 0.0, last = 1.0;
  const auto cut = [&](double from, double to, double low, double high) {
    if (from == to) return low < from && from < high;
    const auto [enter, leave] = std::minmax({(low - from) / (to - from), (high - from) / (to - from)});
    first = std::max(first, enter);
    last = std::min(last, leave);
    return true;
  };
  return cut(line.from.x, line.to.x, box.x0, box.x1) && cut(line.from.y, line.to.y, box.y0, box.y1) && first < last;
}

bool contains(const PixelBox& box, const Pixel& at) {
  return box.x0 < at.x && at.x < box.x1 && box.y0 < at.y && at.y < box.y1;
}

/// Half the length of a disc.
double disc_half_px(Canvas& canvas, const std::string& letters) {
  constexpr double beside_letters_px = 5.0;
  return std::max(disc_radius_px, 0.5 * canvas.text_width_px(letters, disc_style) + beside_letters_px);
}

}  // namespace

void draw_letter_disc(Canvas& canvas, const Pixel& at, const std::string& letters) {
  canvas.disc(at, disc_radius_px, disc_colour, ink, disc_half_px(canvas, letters) - disc_radius_px);
  canvas.text(at, letters, disc_style);
}

bool LabelBoard::is_free(const PixelBox& box) const {
  if (box.x0 < bounds_.x0 || box.x1 > bounds_.x1 || box.y0 < bounds_.y0 || box.y1 > bounds_.y1) return false;
  const auto is_taken = [&](const PixelBox& other) { return overlap(box, other); };
  return std::none_of(kept_.begin(), kept_.end(), is_taken) &&
         std::none_of(canvas_->texts().begin(), canvas_->texts().end(), is_taken) &&
         std::none_of(placed_.begin(), placed_.end(), [&](const Label& label) {
           return overlap(box, label.box) || (label.leader && crosses(*label.leader, box));
         });
}

void LabelBoard::queue(Label label) {
  constexpr double one_place_px = 6.0;
  const Pixel at = middle_of(label.mark);
  for (Label& other : waiting_) {
    const Pixel there = middle_of(other.mark);
    if (other.is_disc != label.is_disc || other.is_on_mark != label.is_on_mark) continue;
    if (std::hypot(at.x - there.x, at.y - there.y) > one_place_px) continue;
    other.words += ", " + label.words;
    return;
  }
  waiting_.push_back(std::move(label));
}

void LabelBoard::add(const PixelBox& mark, const std::string& words, const TextStyle& style) {
  queue({mark, words, style});
}

void LabelBoard::add_on(const Pixel& point, const std::string& words, const TextStyle& style) {
  queue({box_of(point), words, style, false, true});
}

void LabelBoard::add_disc(const Pixel& point, const std::string& letter) {
  queue({box_of(point), letter, disc_style, true, true});
}

PixelBox LabelBoard::box_around(const Pixel& middle, const Label& label) const {
  if (label.is_disc) {
    constexpr double rim_px = 1.0;
    const double half_px = disc_half_px(*canvas_, label.words);
    return grown({middle.x - half_px, middle.y - disc_radius_px, middle.x + half_px, middle.y + disc_radius_px},
                 rim_px);
  }
  constexpr double beside_px = 2.0;
  return grown(canvas_->text_box(middle, label.words, label.style), beside_px);
}

bool LabelBoard::is_clear(const Leader& leader) const {
  // What covers the mark itself is crossed in any case.
  const auto is_crossed = [&](const PixelBox& box) { return crosses(leader, box) && !contains(box, leader.to); };
  return std::none_of(canvas_->texts().begin(), canvas_->texts().end(), is_crossed) &&
         std::none_of(placed_.begin(), placed_.end(), [&](const Label& label) { return is_crossed(label.box); });
}

bool LabelBoard::try_at(Label& label, const Pixel& middle, bool with_clear_leader) const {
  constexpr double near_px = 16.0;
  label.box = box_around(middle, label);
  if (!is_free(label.box)) return false;
  const Pixel end = nearest_in(label.mark, middle), start = nearest_in(label.box, end);
  label.leader.reset();
  const double far_px = std::hypot(end.x - start.x, end.y - start.y);
  if (far_px > (label.is_on_mark ? 0.0 : near_px)) label.leader = Leader{start, end};
  return !with_clear_leader || !label.leader || is_clear(*label.leader);
}

bool LabelBoard::place_one(Label& label, bool with_clear_leader) const {
  const Pixel mark = middle_of(label.mark);
  if (label.is_on_mark && try_at(label, mark, with_clear_leader)) return true;
  const PixelBox box = box_around({0.0, 0.0}, label);
  const double half_width_px = 0.5 * (box.x1 - box.x0 + label.mark.x1 - label.mark.x0);
  const double half_height_px = 0.5 * (box.y1 - box.y0 + label.mark.y1 - label.mark.y0);
  const double farthest_px = std::hypot(bounds_.x1 - bounds_.x0, bounds_.y1 - bounds_.y0);
  constexpr double first_gap_px = 6.0, gap_step_px = 14.0;
  constexpr int directions = 16;
  for (double gap_px = first_gap_px; gap_px < farthest_px; gap_px += gap_step_px) {
    for (int k = 0; k < directions; ++k) {
      // Alternating left and right of straight up.
      const double turn = (k % 2 == 0 ? 1.0 : -1.0) * ((k + 1) / 2) * 2.0 * std::numbers::pi / directions;
      const double ux = std::sin(turn), uy = -std::cos(turn);
      if (try_at(label, {mark.x + ux * (gap_px + half_width_px), mark.y + uy * (gap_px + half_height_px)},
                 with_clear_leader)) {
        return true;
      }
    }
  }
  return false;
}

void LabelBoard::place() {
  std::stable_partition(waiting_.begin(), waiting_.end(), [](const Label& label) { return label.is_on_mark; });
  for (Label& label : std::exchange(waiting_, {})) {
    if (place_one(label, true) || place_one(label, false)) placed_.push_back(std::move(label));
  }
}

void LabelBoard::draw() {
  place();
  for (const Label& label : placed_) {
    if (!label.leader) continue;
    canvas_->line(label.leader->from, label.leader->to, 3.0, {1.0, 1.0, 1.0, 0.7});
    canvas_->line(label.leader->from, label.leader->to, 1.2, label.style.colour);
  }
  for (const Label& label : placed_) {
    if (label.is_disc) {
      draw_letter_disc(*canvas_, middle_of(label.box), label.words);
      continue;
    }
    const PixelBox box = box_around({0.0, 0.0}, label);
    canvas_->text({label.box.x0 - box.x0, label.box.y0 - box.y0}, label.words, label.style);
  }
}

}  // namespace spindle_twin::fem_offline
