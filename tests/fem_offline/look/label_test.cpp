#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "fem_offline/look/picture.hpp"
#include "fem_offline/look/picture_canvas.hpp"
#include "fem_offline/look/picture_frame.hpp"
#include "fem_offline/look/picture_labels.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace look_label_test {

bool overlap(const PixelBox& a, const PixelBox& b) { return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1; }

std::string words_of(const PixelBox& box) {
  return "[" + fixed(box.x0, 0) + ", " + fixed(box.y0, 0) + ", " + fixed(box.x1, 0) + ", " + fixed(box.y1, 0) + "]";
}

void expect_legible(const Canvas& canvas, const std::string& name) {
  const std::vector<PixelBox>& texts = canvas.texts();
  EXPECT_GT(texts.size(), 20U);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const PixelBox& box = texts[i];
    EXPECT_TRUE(box.x0 >= 0.0 && box.y0 >= 0.0 && box.x1 <= canvas.width_px() && box.y1 <= canvas.height_px())
        << name << ": " << words_of(box);
    for (std::size_t j = i + 1; j < texts.size(); ++j) {
      EXPECT_FALSE(overlap(box, texts[j])) << name << ": " << words_of(box) << " and " << words_of(texts[j]);
    }
  }
}

/// Steps along the line, half a pixel apart.
bool runs_through(const Leader& line, const PixelBox& box) {
  const int steps = 1 + static_cast<int>(2.0 * std::hypot(line.to.x - line.from.x, line.to.y - line.from.y));
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const Pixel at{line.from.x + share * (line.to.x - line.from.x), line.from.y + share * (line.to.y - line.from.y)};
    constexpr double touch_px = 0.1;
    if (at.x > box.x0 + touch_px && at.x < box.x1 - touch_px && at.y > box.y0 + touch_px && at.y < box.y1 - touch_px) {
      return true;
    }
  }
  return false;
}

/// Words, discs and numbers of a crowd of points in the middle of a canvas, all placed.
std::vector<Label> crowd(Canvas& canvas, std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(200.0, 600.0);
  LabelBoard board(canvas, {0.0, 0.0, 800.0, 800.0});
  const TextStyle style{15.0, true, Align::centre, ink, true};
  for (int i = 0; i < count; ++i) {
    const Pixel at{anywhere(random), anywhere(random)};
    if (i % 3 == 0) board.add_disc(at, letter_of(static_cast<std::size_t>(i)));
    if (i % 3 == 1) board.add_on(at, std::to_string(i), style);
    if (i % 3 == 2) board.add(box_of(at), "label " + std::to_string(i), style);
  }
  board.place();
  return board.placed();
}

TEST(Labels, of_a_crowd_stand_apart_within_the_bounds_and_their_leaders_run_between_them) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Canvas canvas(800, 800);
    constexpr int count = 30;
    const std::vector<Label> labels = crowd(canvas, seed, count);
    int words = 0;
    for (const Label& label : labels) {
      words += 1 + static_cast<int>(std::count(label.words.begin(), label.words.end(), ','));
      EXPECT_TRUE(label.box.x0 >= 0.0 && label.box.y0 >= 0.0 && label.box.x1 <= 800.0 && label.box.y1 <= 800.0);
      for (const Label& other : labels) {
        if (&other == &label) continue;
        EXPECT_FALSE(overlap(label.box, other.box)) << "seed " << seed << ": " << label.words << ", " << other.words;
        const bool is_above_mark =
            overlap(other.box, {label.mark.x0 - 1, label.mark.y0 - 1, label.mark.x1 + 1, label.mark.y1 + 1});
        EXPECT_FALSE(label.leader && !is_above_mark && runs_through(*label.leader, other.box))
            << "seed " << seed << ": " << label.words << " through " << other.words;
      }
      // What has no line to its mark stands on it or beside it.
      const double right_px = std::max(label.box.x0 - label.mark.x1, label.mark.x0 - label.box.x1);
      const double down_px = std::max(label.box.y0 - label.mark.y1, label.mark.y0 - label.box.y1);
      EXPECT_TRUE(label.leader || std::max(right_px, down_px) <= 16.0) << label.words;
    }
    EXPECT_EQ(words, count) << "seed " << seed << ": every label is there";
  }
}

TEST(Labels, get_the_same_places_each_time) {
  Canvas canvas(800, 800);
  const std::vector<Label> first = crowd(canvas, 7, 30), again = crowd(canvas, 7, 30);
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].words, again[i].words);
    EXPECT_EQ(first[i].box.x0, again[i].box.x0);
    EXPECT_EQ(first[i].box.y0, again[i].box.y0);
  }
}

TEST(Labels, of_one_place_become_one) {
  Canvas canvas(400, 400);
  LabelBoard board(canvas, {0.0, 0.0, 400.0, 400.0});
  for (const char* letter : {"A", "B"}) board.add_disc({200.0, 200.0}, letter);
  board.add(box_of({200.0, 200.0}), "beside", {});
  board.place();
  ASSERT_EQ(board.placed().size(), 2U);
  EXPECT_EQ(board.placed()[0].words, "A, B");
  EXPECT_EQ(board.placed()[1].words, "beside");
}

TEST(Labels, no_two_texts_of_a_picture_overlap_and_none_leaves_it) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles")) {
    if (file.path().extension() != ".toml") continue;
    const FeModel model = build_fe_model(file.path());
    const rom::Boundaries& boundaries = model.affine().boundaries;
    rom::BoundaryValues values = rom::make_boundary_values(boundaries);
    rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
    const SectionPicture picture =
        picture_of(model, solve_steady(model.affine(), values), {"steady state", values.environment_K[0]});
    const std::string name = file.path().stem();
    expect_legible(*draw_parts_picture(picture), name + "_parts");
    expect_legible(*draw_rise_picture(picture), name + "_rise");
    ++count;
  }
  EXPECT_EQ(count, 8);
}

}  // namespace look_label_test
}  // namespace spindle_twin::fem_offline
