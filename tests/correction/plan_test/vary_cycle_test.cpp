#include "correction/plan_test/vary_cycle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace spindle_twin::correction::test {
namespace plan_test_vary_cycle_test {

DriveLimits limits() {
  DriveLimits limits;
  limits.length_s = 3600.0;
  limits.top_rpm = 8000.0;
  limits.shares = {0.0, 0.5, 1.0};
  return limits;
}

double length_s(const DriveCycle& cycle) {
  return std::accumulate(cycle.begin(), cycle.end(), 0.0,
                         [](double sum_s, const Stage& stage) { return sum_s + stage.length_s; });
}

bool has(const std::vector<DriveCycle>& cycles, const DriveCycle& one) {
  return std::find(cycles.begin(), cycles.end(), one) != cycles.end();
}

TEST(VaryCycle, stages_are_of_equal_length_and_take_the_speeds_in_turn) {
  EXPECT_EQ(in_stages(3, {0.25, 1.0}, limits()), (DriveCycle{{1200.0, 2000.0}, {1200.0, 8000.0}, {1200.0, 2000.0}}));
  EXPECT_EQ(in_stages(1, {1.0, 0.0}, limits()), (DriveCycle{{3600.0, 8000.0}}));
}

TEST(VaryCycle, other_speeds_are_all_that_are_allowed_but_its_own) {
  const DriveCycle cycle{{1500.0, 4000.0}, {2100.0, 0.0}};
  EXPECT_EQ(other_speeds(cycle, 0, limits()),
            (std::vector<DriveCycle>{{{1500.0, 0.0}, {2100.0, 0.0}}, {{1500.0, 8000.0}, {2100.0, 0.0}}}));
  EXPECT_EQ(other_speeds(cycle, 1, limits()),
            (std::vector<DriveCycle>{{{1500.0, 4000.0}, {2100.0, 4000.0}}, {{1500.0, 4000.0}, {2100.0, 8000.0}}}));
}

TEST(VaryCycle, a_switch_moves_both_ways_as_far_as_both_stages_stay_long_enough) {
  const DriveCycle cycle{{420.0, 4000.0}, {900.0, 0.0}, {2280.0, 8000.0}};
  EXPECT_EQ(other_times(cycle, 0, limits(), {120.0, 300.0, 600.0}),
            (std::vector<DriveCycle>{{{300.0, 4000.0}, {1020.0, 0.0}, {2280.0, 8000.0}},
                                     {{540.0, 4000.0}, {780.0, 0.0}, {2280.0, 8000.0}},
                                     {{720.0, 4000.0}, {600.0, 0.0}, {2280.0, 8000.0}},
                                     {{1020.0, 4000.0}, {300.0, 0.0}, {2280.0, 8000.0}}}));
  EXPECT_TRUE(other_times(cycle, 1, limits(), {0.0}).empty()) << "no time is no move";
}

TEST(VaryCycle, half_a_length_is_a_whole_number_of_minutes) {
  EXPECT_EQ(half_in_minutes_s(1800.0), 900.0);
  EXPECT_EQ(half_in_minutes_s(1790.0), 840.0);
  EXPECT_EQ(half_in_minutes_s(119.0), 0.0);
}

TEST(VaryCycle, a_stage_is_split_at_either_end_into_the_shortest_part_and_into_halves) {
  const DriveCycle cycle{{1800.0, 4000.0}, {1800.0, 0.0}};
  const std::vector<DriveCycle> found = splits(cycle, 0, limits());
  for (const double part_s : {300.0, 900.0}) {
    EXPECT_TRUE(has(found, {{part_s, 8000.0}, {1800.0 - part_s, 4000.0}, {1800.0, 0.0}})) << part_s;
    EXPECT_TRUE(has(found, {{1800.0 - part_s, 4000.0}, {part_s, 8000.0}, {1800.0, 0.0}})) << part_s;
    EXPECT_TRUE(has(found, {{part_s, 0.0}, {1800.0 - part_s, 4000.0}, {1800.0, 0.0}})) << part_s;
    EXPECT_TRUE(has(found, {{1800.0 - part_s, 4000.0}, {1800.0 + part_s, 0.0}})) << "joined with the next, " << part_s;
  }
  EXPECT_EQ(found.size(), 8U);
  for (const DriveCycle& one : found) EXPECT_EQ(length_s(one), 3600.0);
}

TEST(VaryCycle, a_stage_is_not_split_below_the_shortest_that_is_allowed) {
  EXPECT_TRUE(splits({{590.0, 4000.0}, {3010.0, 0.0}}, 0, limits()).empty());
  // Of ten minutes the shortest part is the half.
  const std::vector<DriveCycle> found = splits({{600.0, 4000.0}, {3000.0, 0.0}}, 0, limits());
  EXPECT_EQ(found.size(), 8U);
  for (const DriveCycle& one : found) {
    for (const Stage& stage : one) EXPECT_GE(stage.length_s, 300.0);
  }
}

}  // namespace plan_test_vary_cycle_test
}  // namespace spindle_twin::correction::test
