#include "correction/calibrate/test_steps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::correction::test {
namespace calibrate_test_steps_test {

rom::OperatingState at_speed(double speed_rpm) {
  rom::OperatingState state;
  state.speed_rpm = speed_rpm;
  state.load = 0.5;
  state.environment_K = Eigen::Vector2d(293.0, 298.0);
  state.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.02);
  state.heat_W = Eigen::VectorXd::Constant(1, 150.0);
  return state;
}

ThermalTest logged(const std::vector<double>& time_s, const std::vector<rom::OperatingState>& operating) {
  ThermalTest test;
  test.time_s = time_s;
  test.operating = operating;
  return test;
}

TEST(TestSteps, grow_with_a_quarter_of_the_time_since_a_change_from_a_twentieth_to_the_longest) {
  const ThermalTest test = logged({0.0, 300.0, 1000.0}, {at_speed(3000.0), at_speed(6000.0), at_speed(6000.0)});
  for (const double longest_s : {20.0, 40.0}) {
    double changed_s = 0.0, now_s = 0.0;
    std::size_t grown = 0;
    for (const TestStep& step : test_steps(test, longest_s)) {
      ASSERT_NEAR(step.begin_s, now_s, 1e-9);
      if (step.begin_s == 300.0) changed_s = 300.0;
      double end_s = now_s + std::clamp(0.25 * (now_s - changed_s), 0.05 * longest_s, longest_s);
      if (now_s < 300.0) end_s = std::min(end_s, 300.0);
      end_s = std::min(end_s, 1000.0);
      EXPECT_NEAR(step.end_s, end_s, 1e-9) << "from " << now_s << " s on";
      grown += step.end_s - step.begin_s > 0.051 * longest_s && step.end_s - step.begin_s < 0.99 * longest_s ? 1 : 0;
      EXPECT_EQ(step.operating.speed_rpm, now_s < 300.0 ? 3000.0 : 6000.0);
      now_s = step.end_s;
    }
    EXPECT_EQ(now_s, 1000.0);
    EXPECT_GT(grown, 10U);
  }
}

TEST(TestSteps, are_short_again_after_a_change_at_which_one_ends_anyway) {
  const ThermalTest test = logged({0.0, 3.0, 100.0}, {at_speed(3000.0), at_speed(6000.0), at_speed(6000.0)});
  double now_s = 0.0;
  for (const TestStep& step : test_steps(test, 20.0)) {
    ASSERT_EQ(step.begin_s, now_s);
    EXPECT_EQ(std::min(step.end_s, 7.0) - step.begin_s, now_s < 7.0 ? 1.0 : 7.0 - now_s);
    now_s = step.end_s;
  }
}

TEST(TestSteps, of_a_single_instant_are_none_and_of_two_end_at_the_second) {
  EXPECT_TRUE(test_steps(logged({7.0}, {at_speed(0.0)}), 20.0).empty());
  const std::vector<TestStep> steps = test_steps(logged({7.0, 7.4}, {at_speed(0.0), at_speed(0.0)}), 20.0);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].begin_s, 7.0);
  EXPECT_EQ(steps[0].end_s, 7.4);
}

TEST(TestSteps, leave_no_sliver_of_a_microsecond_before_the_end) {
  // The first step is a twentieth of the longest: it ends half a microsecond, and one and a half, before the log does.
  for (const double left_s : {0.5e-6, 1.5e-6}) {
    const std::vector<TestStep> steps = test_steps(logged({0.0, 1.0 + left_s}, {at_speed(0.0), at_speed(0.0)}), 20.0);
    EXPECT_EQ(steps.size(), left_s > 1e-6 ? 2U : 1U);
    EXPECT_EQ(steps.back().end_s, 1.0 + left_s);
  }
}

/// Inputs that wander less than ends a step: the mean weighs each instant by how long it held.
TEST(TestSteps, take_loads_flows_heats_and_inlets_by_how_long_each_held) {
  std::vector<rom::OperatingState> states(4, at_speed(6000.0));
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double way = i % 2 == 0 ? 1.0 : -1.0;
    states[i].flow_kg_per_s *= 1.0 + 5e-4 * way;
    states[i].heat_W *= 1.0 + 0.01 * way;
    states[i].load += 1e-3 * way;
    states[i].current_A = 12.0 + 0.1 * way;
    states[i].power_W = 1500.0 + 10.0 * way;
    states[i].environment_K[0] += way;
    states[i].environment_K[1] -= 2.0 * way;
  }
  const ThermalTest test = logged({0.0, 400.0, 405.0, 460.0}, states);
  const std::vector<TestStep> steps = test_steps(test, 20.0);
  const auto over = std::find_if(steps.begin(), steps.end(),
                                 [](const TestStep& step) { return step.begin_s < 400.0 && step.end_s > 405.0; });
  ASSERT_NE(over, steps.end());
  const double share = 5.0 / (over->end_s - over->begin_s), mean = 1.0 - 2.0 * share;  // the second instant's
  EXPECT_NEAR(over->operating.flow_kg_per_s[0], 0.02 * (1.0 + 5e-4 * mean), 1e-14);
  EXPECT_NEAR(over->operating.heat_W[0], 150.0 * (1.0 + 0.01 * mean), 1e-10);
  EXPECT_NEAR(over->operating.environment_K[0], 293.0 + mean, 1e-10);
  EXPECT_NEAR(over->operating.environment_K[1], 298.0 - 2.0 * mean, 1e-10);
  EXPECT_NEAR(over->operating.load, 0.5 + 1e-3 * mean, 1e-13);
  EXPECT_NEAR(over->operating.current_A.value(), 12.0 + 0.1 * mean, 1e-11);
  EXPECT_NEAR(over->operating.power_W.value(), 1500.0 + 10.0 * mean, 1e-9);
}

TEST(TestSteps, end_where_a_current_is_told_first_and_know_it_from_there_on) {
  std::vector<rom::OperatingState> states(3, at_speed(6000.0));
  states[1].current_A = states[2].current_A = 12.0;
  const std::vector<TestStep> steps = test_steps(logged({0.0, 201.0, 300.0}, states), 20.0);
  bool ends_there = false;
  for (const TestStep& step : steps) {
    ends_there = ends_there || step.end_s == 201.0;
    EXPECT_EQ(step.operating.current_A.has_value(), step.begin_s >= 201.0) << step.begin_s;
    EXPECT_NEAR(step.operating.current_A.value_or(12.0), 12.0, 1e-12);
  }
  EXPECT_TRUE(ends_there);
}

/// What the log says between the ends of two steps is of neither end alone, also where instants lie closer than a step.
TEST(TestSteps, of_instants_closer_than_a_step_lose_none_of_them) {
  std::vector<double> time_s;
  std::vector<rom::OperatingState> states;
  for (int k = 0; k <= 900; ++k) {
    time_s.push_back(0.7 * k);
    states.push_back(at_speed(6000.0));
    states.back().environment_K[0] += std::sin(0.3 * k);
  }
  const ThermalTest test = logged(time_s, states);
  double summed = 0.0, expected = 0.0;
  for (const TestStep& step : test_steps(test, 20.0)) {
    summed += (step.end_s - step.begin_s) * (step.operating.environment_K[0] - 293.0);
  }
  for (int k = 0; k < 900; ++k) expected += 0.7 * std::sin(0.3 * k);
  EXPECT_NEAR(summed, expected, 1e-8);
}

TEST(TestOptions, of_a_calibration_are_those_that_are_stated) {
  const CalibrateOptions options;
  EXPECT_EQ(options.lag_deviation_s, 14.0);
  EXPECT_EQ(options.interval_s, 60.0);
  EXPECT_EQ(options.held_s, 60.0);
  EXPECT_EQ(options.longest_step_s, 20.0);
  EXPECT_EQ(options.probe_noise_m, 1e-6);
  EXPECT_EQ(options.probe_drift_m, 0.5e-6);
  EXPECT_EQ(options.sensor_error_K, 0.05);
  EXPECT_EQ(options.sensor_error_share, 0.01);
  EXPECT_EQ(options.joint_wander, 0.12);
  EXPECT_EQ(options.memory_s, 3600.0);
  EXPECT_EQ(options.starts, 5);
  EXPECT_EQ(options.start_seed, 1U);
  ThermalTest test;
  test.time_s = {30.0, 100.0, 210.0};
  EXPECT_EQ(test.length_s(), 180.0);
}

}  // namespace calibrate_test_steps_test
}  // namespace spindle_twin::correction::test
