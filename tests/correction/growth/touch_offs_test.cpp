#include "correction/growth/touch_offs.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace spindle_twin::correction {
namespace touch_offs_test {

constexpr double um = 1e-6;

/// Rows as a history has them: published, tares, orders, output and length of the last.
struct Row {
  double published_um, tares, orders, output, length_um;
  double deviation_um = 1.0;
};

std::vector<GrowthReading> found(const std::vector<Row>& rows, std::size_t output = 0) {
  TouchOffs touch_offs(output);
  touch_offs.begin_run();
  std::vector<GrowthReading> readings;
  double unix_s = 0.0;
  for (const Row& row : rows) {
    const auto reading = touch_offs.row({++unix_s, row.published_um * um, row.tares, row.orders, row.output,
                                         row.length_um * um, row.deviation_um * um});
    if (reading) readings.push_back(*reading);
  }
  return readings;
}

TEST(TouchOffs, a_length_stands_beside_what_was_published_before_it_was_known) {
  const auto readings = found({{1, 0, 4, 0, 9}, {2, 0, 4, 0, 9}, {7, 0, 5, 0, 3}, {8, 0, 5, 0, 3}});
  ASSERT_EQ(readings.size(), 1U) << "those of before the first row are not known";
  EXPECT_EQ(readings[0].unix_s, 3.0);
  EXPECT_DOUBLE_EQ(readings[0].measured_m, 3 * um);
  EXPECT_DOUBLE_EQ(readings[0].predicted_m, 2 * um);
}

TEST(TouchOffs, rows_between_two_of_the_same_numbers_may_be_left_out) {
  const std::vector<Row> rows = {{1, 0, 0, 0, 0}, {2, 0, 0, 0, 0}, {3, 0, 0, 0, 0}, {4, 0, 1, 0, 5}, {5, 0, 1, 0, 5}};
  const auto all = found(rows), some = found({rows[0], rows[2], rows[3]});
  ASSERT_EQ(all.size(), 1U);
  ASSERT_EQ(some.size(), 1U);
  EXPECT_EQ(all[0].predicted_m, some[0].predicted_m);
}

TEST(TouchOffs, of_another_output_beside_a_tare_or_without_a_prediction_there_is_none) {
  EXPECT_TRUE(found({{1, 0, 0, 0, 0}, {1, 0, 1, 1, 5}}).empty());
  EXPECT_EQ(found({{1, 0, 0, 0, 0}, {1, 0, 1, 1, 5}}, 1).size(), 1U);
  EXPECT_TRUE(found({{1, 0, 0, 0, 0}, {0, 1, 1, 0, 5}}).empty());
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(found({{none, 0, 0, 0, 0}, {1, 0, 1, 0, 5}}).empty());
  EXPECT_TRUE(found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, none}}).empty());
}

TEST(TouchOffs, what_the_daemon_refuses_is_none) {
  EXPECT_EQ(found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, 5, 0.1}}).size(), 1U);
  for (const double deviation_um : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, 5, deviation_um}}).empty());
  }
  EXPECT_EQ(found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, -9999}}).size(), 1U);
  EXPECT_TRUE(found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, 10001}}).empty());
}

TEST(TouchOffs, a_reading_has_the_number_of_the_stretch_of_its_row) {
  const auto readings = found({{1, 0, 0, 0, 0}, {1, 0, 1, 0, 5}, {1, 0, 2, 0, 6}, {1, 1, 3, 0, 7}, {1, 1, 4, 0, 8}});
  ASSERT_EQ(readings.size(), 3U) << "what comes with a tare is none";
  EXPECT_EQ(readings[0].stretch, 0U);
  EXPECT_EQ(readings[1].stretch, 0U);
  EXPECT_EQ(readings[2].stretch, 1U);
}

TEST(TouchOffs, starts_and_tares_begin_a_stretch) {
  TouchOffs touch_offs(0);
  for (int run = 0; run < 2; ++run) {
    touch_offs.begin_run();
    for (const double tares : {0.0, 0.0, 1.0, 1.0}) touch_offs.row({0.0, 0.0, tares, 0.0, 0.0, 0.0});
  }
  EXPECT_EQ(touch_offs.stretches(), 4U);
}

}  // namespace touch_offs_test
}  // namespace spindle_twin::correction
