#include "correction/plan_test/test_worth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "correction/plan_test/plan_test.hpp"
#include "rom/read/input_error.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace plan_test_test_worth_test {

/// plates() with one sensor in service and another for the test; a reading each two minutes.
struct Planned {
  Planned() : network(plates()) {
    options.calibrate = thinned(calibrate_options(network), 120.0);
    options.calibrate.sensors.resize(2);
    options.permanent = 1;
    service = schedule_of({{1200.0, 6000.0}, {600.0, 0.0}}, {}, network.boundaries);
    test = schedule_of({{600.0, 9000.0}, {330.0, 3000.0}}, {}, network.boundaries);
  }
  TestWorth worth() const { return TestWorth(network, options, service); }

  rom::Network network;
  WorthOptions options;
  rom::Schedule service, test;
};

TEST(TestWorth, what_the_sensors_would_rise_is_what_the_model_says_and_a_probe_has_none) {
  const Planned planned;
  const TestPrediction found = planned.worth().linearise(planned.test);
  double last_s = 0.0, largest_K = 0.0;
  for (const TestReading& reading : found.readings) {
    last_s = std::max(last_s, reading.time_s);
    if (reading.channel >= 2) {
      EXPECT_EQ(reading.rise, 0.0);
      EXPECT_EQ(reading.value, 0.0);
      continue;
    }
    EXPECT_EQ(reading.rise, -reading.residual);
    largest_K = std::max(largest_K, reading.rise);
  }
  EXPECT_GT(largest_K, 1.0);
  EXPECT_EQ(last_s, 900.0) << "after the first minute each two minutes";
}

TEST(TestWorth, readings_up_to_an_instant_are_those_of_that_instant_too) {
  const Planned planned;
  const TestWorth worth = planned.worth();
  const TestPrediction found = worth.linearise(planned.test);
  const double at_s = 420.0;
  ASSERT_TRUE(std::any_of(found.readings.begin(), found.readings.end(),
                          [&](const TestReading& reading) { return reading.time_s == at_s; }));
  const auto left_m = [&](double until_s) { return worth.of(found, {{0, 1}, true, until_s}).with_sensors_m; };
  EXPECT_EQ(left_m(at_s), left_m(at_s + 100.0));
  EXPECT_LT(left_m(at_s), left_m(at_s - 1.0));
  EXPECT_EQ(left_m(1.0), worth.untested().with_sensors_m);
}

TEST(TestWorth, drift_adds_its_square_to_what_a_test_leaves_and_to_what_is_left_of_a_known_machine_alike) {
  Planned planned;
  const auto squares_m2 = [&](double drift) {
    planned.options.drift = {drift, drift, drift};
    const TestWorth worth = planned.worth();
    const double tested_m = worth.of(worth.linearise(planned.test), {{0, 1}, true}).open_loop_m;
    return Eigen::Vector2d(std::pow(tested_m, 2.0), std::pow(worth.known().open_loop_m, 2.0));
  };
  const Eigen::Vector2d none = squares_m2(0.0), some = squares_m2(0.1) - none, twice = squares_m2(0.2) - none;
  ASSERT_GT(some[0], 0.0);
  EXPECT_LT(none[1], none[0]);
  EXPECT_NEAR(some[0], some[1], 1e-6 * some[0]);
  EXPECT_NEAR(twice[0], 4.0 * some[0], 1e-6 * twice[0]);
  EXPECT_NEAR(twice[1], 4.0 * some[1], 1e-6 * twice[1]);
}

TEST(TestWorth, service_is_judged_from_its_instant_on_and_refused_where_it_ends_before) {
  Planned planned;
  planned.options.judged_from_s = 1740.0;
  EXPECT_GT(planned.worth().untested().open_loop_m, 0.0) << "the last instant alone";
  planned.options.judged_from_s = 1740.1;
  EXPECT_THROW(planned.worth(), rom::InputError);
}

/// rms over instants: of all of them the squares of two parts, each weighed by how many it has.
TEST(TestWorth, over_service_is_the_root_of_the_mean_square_over_its_instants) {
  Planned planned;
  planned.options.permanent = 0;
  const auto square_of = [&](double from_s) {
    planned.options.judged_from_s = from_s;
    return std::pow(planned.worth().untested().open_loop_m, 2.0);
  };
  // Instants each 120 s, after the first minute.
  const double last_m2 = square_of(1740.0), last_two_m2 = square_of(1620.0), last_three_m2 = square_of(1500.0);
  const double second_m2 = 2.0 * last_two_m2 - last_m2, third_m2 = 3.0 * last_three_m2 - 2.0 * last_two_m2;
  EXPECT_LT(last_three_m2, 2.0 * last_m2) << "a mean, no sum";
  EXPECT_GT(second_m2, last_m2) << "it cools";
  EXPECT_GT(third_m2, second_m2);
  planned.options.judged_from_s = 1500.0;
  const Worth worth = planned.worth().untested();
  EXPECT_EQ(worth.with_sensors_m, worth.open_loop_m) << "no sensor in service tells anything";
}

TEST(TestWorth, what_comes_after_an_instant_changes_nothing_before_it) {
  const Planned planned;
  const TestWorth worth = planned.worth();
  const rom::Schedule constant = schedule_of({{930.0, 9000.0}}, {}, planned.network.boundaries);
  const TestPrediction slower = worth.linearise(planned.test), steady = worth.linearise(constant);
  ASSERT_EQ(slower.readings.size(), steady.readings.size());
  int after = 0;
  for (std::size_t r = 0; r < slower.readings.size(); ++r) {
    const TestReading &one = slower.readings[r], &other = steady.readings[r];
    ASSERT_EQ(one.time_s, other.time_s);
    if (one.time_s <= 600.0) {
      EXPECT_NEAR(one.residual, other.residual, 1e-9) << one.time_s;
    } else if (one.channel == 0) {
      EXPECT_LT(one.rise, other.rise - 0.1) << one.time_s;
      ++after;
    }
  }
  EXPECT_EQ(after, 3);
}

TEST(TestWorth, a_stage_ends_when_it_says_also_between_two_readings) {
  Planned planned;
  planned.options.calibrate.longest_step_s = 10.0;
  planned.service = schedule_of({{60.0, 9000.0}}, {}, planned.network.boundaries);  // which is of no matter here
  planned.options.judged_from_s = 0.0;
  const rom::Schedule drive = schedule_of({{631.0, 9000.0}, {269.0, 0.0}}, {}, planned.network.boundaries);
  const auto last_K = [&](double held_s) {
    planned.options.calibrate.held_s = held_s;
    planned.options.calibrate.interval_s = 0.0;
    double rise_K = 0.0;
    for (const TestReading& reading : planned.worth().linearise(drive).readings) {
      if (reading.channel == 0) rise_K = reading.rise;
    }
    return rise_K;
  };
  // At the end of periods of a minute, and of 5 s.
  const double coarse_K = last_K(60.0), fine_K = last_K(5.0);
  EXPECT_GT(fine_K, 1.0);
  EXPECT_NEAR(coarse_K, fine_K, 0.02 * fine_K);
}

/// One minute of service, with one reading of its sensor at its end.
TEST(TestWorth, a_reading_of_service_tells_of_its_own_instant_by_how_sure_it_is) {
  Planned planned;
  planned.service = schedule_of({{60.0, 9000.0}}, {}, planned.network.boundaries);
  planned.options.judged_from_s = 0.0;
  const Worth told = planned.worth().untested();
  EXPECT_LT(told.with_sensors_m, 0.99 * told.open_loop_m);
  planned.options.calibrate.sensor_error_K = 1e4;
  const Worth nothing = planned.worth().untested();
  EXPECT_NEAR(nothing.with_sensors_m, nothing.open_loop_m, 1e-6 * nothing.open_loop_m);
  EXPECT_NEAR(nothing.open_loop_m, told.open_loop_m, 1e-12 * told.open_loop_m);
}

TEST(TestWorth, the_first_reading_of_a_test_tells_something) {
  Planned planned;
  planned.options.drift = {0.0, 0.0, 0.0};
  const TestWorth worth = planned.worth();
  const TestPrediction found = worth.linearise(planned.test);
  EXPECT_LT(worth.of(found, {{0}, false, 60.0}).open_loop_m, 0.9999 * worth.untested().open_loop_m);
}

TEST(TestWorth, of_a_length_behind_the_last_is_refused) {
  Planned planned;
  planned.options.probe = planned.network.deformations.size();
  EXPECT_THROW(planned.worth(), rom::InputError);
}

TEST(TestWorth, with_no_reading_of_the_test_is_that_of_the_priors) {
  const Planned planned;
  const TestWorth worth = planned.worth();
  const TestPrediction found = worth.linearise(planned.test);
  EXPECT_EQ(worth.of(found, {{}, false}).open_loop_m, worth.untested().open_loop_m);
  EXPECT_LT(worth.of(found, {{1}, false}).open_loop_m, worth.untested().open_loop_m);
  EXPECT_LT(worth.of(found, {{}, true}).open_loop_m, worth.untested().open_loop_m);
}

TEST(TestWorth, the_order_in_which_sensors_are_named_is_of_no_matter) {
  const Planned planned;
  const TestWorth worth = planned.worth();
  const TestPrediction found = worth.linearise(planned.test);
  const Worth one = worth.of(found, {{0, 1}, true}), other = worth.of(found, {{1, 0}, true});
  EXPECT_NEAR(one.with_sensors_m, other.with_sensors_m, 1e-9 * one.with_sensors_m);
}

TEST(PlannedSensors, are_as_many_as_asked_for_and_all_candidates_are_told_of) {
  const Planned planned;
  const TestWorth worth = planned.worth();
  const TestPrediction found = worth.linearise(planned.test);
  for (const int count : {0, 1, 2}) {
    TestPlan plan;
    plan_sensors(worth, found, {}, 2, count, plan);
    EXPECT_EQ(plan.temporary.size(), static_cast<std::size_t>(count));
    EXPECT_EQ(plan.candidates.size(), 2U) << count;
    EXPECT_EQ(plan.without.size(), static_cast<std::size_t>(count));
    if (count != 1) continue;
    EXPECT_EQ(plan.temporary[0].worth.with_sensors_m,
              worth.of(found, {{plan.temporary[0].sensor}, true}).with_sensors_m);
    EXPECT_EQ(plan.without[0].worth.with_sensors_m, worth.of(found, {{}, true}).with_sensors_m);
  }
  TestPlan beside;
  plan_sensors(worth, found, {0}, 1, 1, beside);
  ASSERT_EQ(beside.candidates.size(), 1U);
  EXPECT_EQ(beside.candidates[0].sensor, 1U) << "candidates are numbered behind those that stay";
  EXPECT_EQ(beside.without.size(), 2U);
}

TEST(ThinnedOptions, let_one_reading_of_a_longer_interval_stand_for_those_between) {
  const rom::Network network = plates();
  CalibrateOptions usual = calibrate_options(network);
  usual.sensors[0].noise_K = 0.04;
  const CalibrateOptions thin = thinned(usual, 240.0);
  EXPECT_EQ(thin.interval_s, 240.0);
  EXPECT_EQ(thin.held_s, 60.0);
  EXPECT_EQ(thin.longest_step_s, 240.0);
  EXPECT_DOUBLE_EQ(thin.probe_noise_m, 0.5e-6);
  EXPECT_DOUBLE_EQ(thin.sensor_error_K, 0.025);
  EXPECT_DOUBLE_EQ(thin.sensor_error_share, 0.005);
  EXPECT_DOUBLE_EQ(thin.sensors[0].noise_K, 0.02);
  EXPECT_EQ(thin.probe_drift_m, usual.probe_drift_m) << "of an hour, however often it is read";
  EXPECT_EQ(thinned(usual, 30.0).held_s, 30.0);
}

}  // namespace plan_test_test_worth_test
}  // namespace spindle_twin::correction::test
