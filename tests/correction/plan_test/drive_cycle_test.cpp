#include "correction/plan_test/drive_cycle.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "correction/plan_test/test_worth.hpp"

namespace spindle_twin::correction::test {
namespace plan_test_drive_cycle_test {

rom::Boundaries described() {
  rom::Boundaries boundaries;
  boundaries.operating.speed_rpm = 1234.0;
  boundaries.operating.load = 0.9;
  boundaries.operating.environment_K = Eigen::Vector2d(293.0, 297.0);
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.05);
  return boundaries;
}

TEST(DriveCycle, begins_each_stage_where_the_one_before_ends_and_ends_with_the_last) {
  DriveLimits limits;
  limits.load = 0.4;
  const rom::Boundaries boundaries = described();
  const rom::Schedule schedule = schedule_of({{300.0, 0.5}, {600.0, 0.0}, {450.0, 9000.0}}, limits, boundaries);
  ASSERT_EQ(schedule.rows.size(), 4U);
  const double begin_s[] = {0.0, 300.0, 900.0, 1350.0}, speed_rpm[] = {0.5, 0.0, 9000.0, 9000.0};
  for (std::size_t i = 0; i < 4; ++i) {
    const rom::OperatingState& state = schedule.rows[i].state;
    EXPECT_EQ(schedule.rows[i].time_s, begin_s[i]);
    EXPECT_EQ(state.speed_rpm, speed_rpm[i]);
    EXPECT_EQ(state.load, speed_rpm[i] > 0.0 ? 0.4 : 0.0);
    EXPECT_EQ(schedule.rows[i].line, 0) << "of no file";
    EXPECT_EQ(state.environment_K, boundaries.operating.environment_K);
    EXPECT_EQ(state.flow_kg_per_s, boundaries.operating.flow_kg_per_s);
  }
  EXPECT_EQ(schedule.end_s, 1350.0);
}

TEST(DriveCycle, of_one_speed_is_one_stage_of_it) {
  EXPECT_EQ(constant_cycle(4000.0, 900.0), (DriveCycle{{900.0, 4000.0}}));
  EXPECT_EQ(joined({}), DriveCycle{});
  EXPECT_EQ(joined({{60.0, 0.0}, {60.0, 1000.0}, {90.0, 1000.0}}), (DriveCycle{{60.0, 0.0}, {150.0, 1000.0}}));
  const DriveCycle apart{{60.0, 1000.0}, {60.0, 0.0}, {60.0, 1000.0}};
  EXPECT_EQ(joined(apart), apart) << "equal speeds that are not neighbours stay apart";
}

/// ISO 230-3 leaves the spectrum to the parties; the header says this one.
TEST(DriveCycle, of_a_spectrum_is_three_minutes_at_each_quarter_of_the_top_speed_and_at_standstill_again_and_again) {
  DriveLimits limits;
  limits.top_rpm = 8000.0;
  limits.length_s = 2000.0;
  const DriveCycle cycle = spectrum_cycle(limits);
  const double shares[] = {0.25, 0.5, 0.75, 1.0, 0.0};
  ASSERT_EQ(cycle.size(), 12U);
  double left_s = 2000.0;
  for (std::size_t k = 0; k < cycle.size(); ++k) {
    EXPECT_EQ(cycle[k].speed_rpm, 8000.0 * shares[k % 5]) << k;
    EXPECT_EQ(cycle[k].length_s, std::min(180.0, left_s)) << k;
    left_s -= cycle[k].length_s;
  }
  EXPECT_EQ(left_s, 0.0);
  limits.length_s = 360.5;
  EXPECT_EQ(spectrum_cycle(limits).back().length_s, 0.5) << "also less than a second";
}

TEST(DriveCycle, of_a_day_of_work_is_the_one_that_plans_are_judged_by) {
  const rom::Schedule day = usual_service(1000.0, described());
  const double minutes[] = {0.0, 40.0, 70.0, 85.0, 130.0, 160.0, 200.0, 240.0};
  const double speed_rpm[] = {500.0, 1000.0, 0.0, 750.0, 250.0, 1000.0, 500.0, 500.0};
  ASSERT_EQ(day.rows.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(day.rows[i].time_s, 60.0 * minutes[i]) << i;
    EXPECT_EQ(day.rows[i].state.speed_rpm, speed_rpm[i]) << i;
    EXPECT_EQ(day.rows[i].state.load, speed_rpm[i] > 0.0 ? 0.5 : 0.0) << i;
  }
}

TEST(DriveLimits, are_those_that_are_stated) {
  const DriveLimits limits;
  EXPECT_EQ(limits.length_s, 7200.0);
  EXPECT_EQ(limits.shortest_s, 300.0);
  EXPECT_EQ(limits.shares, (std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0}));
  EXPECT_EQ(limits.load, 0.0);
  const WorthOptions worth;
  EXPECT_EQ(worth.judged_from_s, 900.0) << "a quarter of an hour, in which a start is still open";
  EXPECT_EQ(worth.probe, 0U);
  EXPECT_EQ(worth.permanent, 0U);
  EXPECT_TRUE(TakenReadings{}.probe);
}

}  // namespace plan_test_drive_cycle_test
}  // namespace spindle_twin::correction::test
