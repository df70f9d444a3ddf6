#include "correction/plan_test/plan_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "correction/calibrate/fit.hpp"
#include "correction/calibrate/unknowns.hpp"
#include "rom/read/input_error.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace plan_test_plan_test_test {

constexpr double top_rpm = 9000.0;

/// plates() with one sensor in service and two more for the test.
WorthOptions worth_options(const rom::Network& network) {
  WorthOptions options;
  options.calibrate = thinned(calibrate_options(network), 120.0);
  options.calibrate.sensors.resize(3);
  options.permanent = 1;
  return options;
}

rom::Schedule short_service(const rom::Network& network) {
  DriveLimits limits;
  return schedule_of({{1800.0, 6000.0}, {1800.0, 0.0}}, limits, network.boundaries);
}

DriveLimits limits_of(double length_s) {
  DriveLimits limits;
  limits.length_s = length_s;
  limits.top_rpm = top_rpm;
  limits.shares = {0.0, 0.5, 1.0};
  return limits;
}

TEST(PlanTest, a_reading_more_and_a_longer_test_never_hurt) {
  const rom::Network network = plates();
  const TestWorth worth(network, worth_options(network), short_service(network));
  const Worth untested = worth.untested();
  const TestPrediction test =
      worth.linearise(schedule_of({{900.0, top_rpm}, {900.0, 0.0}}, limits_of(1800.0), network.boundaries));
  Worth before = untested;
  for (const double until_s : {300.0, 600.0, 1200.0, 1800.0}) {
    const Worth now = worth.of(test, {{0}, true, until_s});
    EXPECT_LE(now.with_sensors_m, before.with_sensors_m * (1.0 + 1e-9)) << until_s;
    EXPECT_LE(now.open_loop_m, before.open_loop_m * (1.0 + 1e-9)) << until_s;
    before = now;
  }
  const Worth without_probe = worth.of(test, {{0}, false}), one = worth.of(test, {{0}, true});
  const Worth two = worth.of(test, {{0, 1}, true}), three = worth.of(test, {{0, 1, 2}, true});
  EXPECT_LT(one.with_sensors_m, without_probe.with_sensors_m);
  EXPECT_LT(two.with_sensors_m, one.with_sensors_m);
  EXPECT_LT(three.with_sensors_m, two.with_sensors_m);
  EXPECT_LT(three.with_sensors_m, three.open_loop_m) << "a sensor in service tells something of its day";
}

TEST(PlanTest, a_spindle_that_stands_tells_little_of_its_heats_and_the_stage_at_speed_tells_them) {
  const rom::Network network = plates();
  const TestWorth worth(network, worth_options(network), short_service(network));
  const TestPrediction test =
      worth.linearise(schedule_of({{1800.0, 0.0}, {1800.0, top_rpm}}, limits_of(3600.0), network.boundaries));
  const double untested_m = worth.untested().open_loop_m;
  EXPECT_GT(worth.of(test, {{0, 1, 2}, true, 1800.0}).open_loop_m, 0.9 * untested_m);
  EXPECT_LT(worth.of(test, {{0, 1, 2}, true}).open_loop_m, 0.5 * untested_m);
}

TEST(PlanTest, more_drift_since_the_test_leaves_more_and_no_reading_leaves_the_prior) {
  const rom::Network network = plates();
  WorthOptions options = worth_options(network);
  const rom::Schedule service = short_service(network);
  const rom::Schedule drive = schedule_of({{1800.0, top_rpm}}, limits_of(1800.0), network.boundaries);
  double before_m = 0.0;
  for (const double drift : {0.0, 0.1, 0.3}) {
    options.drift = {drift, drift, drift};
    const TestWorth worth(network, options, service);
    const TestPrediction test = worth.linearise(drive);
    const double left_m = worth.of(test, {{0}, true}).with_sensors_m;
    EXPECT_GT(left_m, before_m);
    EXPECT_GE(left_m, worth.known().with_sensors_m) << "no test betters a machine that is known";
    EXPECT_EQ(worth.of(test, {{}, false}).with_sensors_m, worth.untested().with_sensors_m);
    before_m = left_m;
  }
}

TEST(PlanTest, the_posterior_is_that_of_the_fit_of_such_a_test) {
  // With readings as the model has them, calibrate's last linearisation is this one: at the means of the priors.
  const rom::Network network = plates();
  CalibrateOptions calibrate = calibrate_options(network);
  calibrate.held_s = 60.0;
  WorthOptions options;
  options.calibrate = calibrate;
  options.drift = {0.0, 0.0, 0.0};
  options.judged_from_s = 1799.0;
  const rom::Schedule drive = schedule_of({{1800.0, top_rpm}}, limits_of(1800.0), network.boundaries);
  const TestWorth worth(network, options, drive);
  const TestPrediction test = worth.linearise(drive);
  const TestPredictor predictor(network, calibrate);
  const TestUnknowns unknowns(network, predictor.parameters(), calibrate, 1);

  ThermalTest recorded;
  recorded.name = "exact";
  recorded.start_K = network.boundaries.reference_temperature_K;
  for (double time_s = 0.0; time_s <= 1800.0; time_s += 60.0) {
    recorded.time_s.push_back(time_s);
    recorded.operating.push_back(drive.rows.front().state);
  }
  const auto rows = static_cast<Eigen::Index>(recorded.time_s.size());
  recorded.measured_K = Eigen::MatrixXd::Constant(rows, 4, recorded.start_K);
  recorded.deformation_m = Eigen::MatrixXd::Zero(rows, 1);
  const TestPrediction model =
      predictor.predict(recorded, unknowns.theta(unknowns.mean(), 0), unknowns.lag_s(unknowns.mean()));
  std::vector<int> next(5, 1);
  for (const TestReading& reading : model.readings) {
    const int row = next[static_cast<std::size_t>(reading.channel)]++;
    // The first mean is of the start too, where nothing is left.
    const double left = reading.samples * reading.residual;
    if (reading.channel < 4) {
      recorded.measured_K(row, reading.channel) -= left;
    } else {
      recorded.deformation_m(row, 0) = -left;
    }
  }
  const TestFit fit = fit_tests({network, predictor, calibrate, {recorded}}, nullptr, {});
  const auto machine = static_cast<Eigen::Index>(unknowns.machine().size());
  EXPECT_LT((fit.z - unknowns.mean()).head(machine).cwiseAbs().maxCoeff(), 0.02) << "nothing was to be found";
  // Service is the same drive once more, judged at its end: the machine as fitted, the day as before.
  const Eigen::VectorXd row = unknowns.row(fit.readings[0].last_output, 0);
  Eigen::MatrixXd covariance = unknowns.root() * unknowns.root().transpose();
  covariance.topLeftCorner(machine, machine) = fit.covariance.topLeftCorner(machine, machine);
  const double expected_m = std::sqrt(row.dot(covariance * row));
  EXPECT_NEAR(worth.of(test, {{0, 1, 2, 3}, true}).open_loop_m, expected_m, 0.01 * expected_m);
}

TEST(PlanTest, the_search_beats_what_it_began_with_keeps_its_limits_and_comes_out_the_same_again) {
  const rom::Network network = plates();
  const TestWorth worth(network, worth_options(network), short_service(network));
  const DriveLimits limits = limits_of(1800.0);
  const TestPlan plan = plan_cycle(worth, limits, network.boundaries, {0});
  const TestPlan again = plan_cycle(worth, limits, network.boundaries, {0});
  EXPECT_EQ(plan.cycle, again.cycle);
  EXPECT_EQ(plan.worth.with_sensors_m, again.worth.with_sensors_m);
  double length_s = 0.0;
  for (const Stage& stage : plan.cycle) {
    EXPECT_GE(stage.length_s, limits.shortest_s);
    EXPECT_TRUE(stage.speed_rpm == 0.0 || stage.speed_rpm == 0.5 * top_rpm || stage.speed_rpm == top_rpm);
    length_s += stage.length_s;
  }
  EXPECT_NEAR(length_s, limits.length_s, 1e-6);
  for (const DriveCycle& other : {constant_cycle(top_rpm, 1800.0), constant_cycle(0.5 * top_rpm, 1800.0)}) {
    const TestPrediction test = worth.linearise(schedule_of(other, limits, network.boundaries));
    EXPECT_LE(plan.worth.with_sensors_m, worth.of(test, {{0}, true}).with_sensors_m);
  }
}

/// Each stage, its first half and its second half, at each other speed.
std::vector<DriveCycle> neighbours_of(const DriveCycle& cycle, const DriveLimits& limits) {
  std::vector<DriveCycle> others;
  for (std::size_t k = 0; k < cycle.size(); ++k) {
    for (const double share : limits.shares) {
      const Stage whole = cycle[k], half{0.5 * whole.length_s, whole.speed_rpm},
                  other{half.length_s, share * limits.top_rpm};
      if (other.speed_rpm == whole.speed_rpm) continue;
      for (const std::vector<Stage>& instead :
           {std::vector<Stage>{{whole.length_s, other.speed_rpm}}, {other, half}, {half, other}}) {
        if (instead.size() > 1 && half.length_s < limits.shortest_s) continue;
        DriveCycle moved(cycle.begin(), cycle.begin() + static_cast<std::ptrdiff_t>(k));
        moved.insert(moved.end(), instead.begin(), instead.end());
        moved.insert(moved.end(), cycle.begin() + static_cast<std::ptrdiff_t>(k) + 1, cycle.end());
        others.push_back(joined(moved));
      }
    }
  }
  return others;
}

TEST(PlanTest, a_search_that_ended_by_itself_has_found_what_no_other_speed_of_a_stage_or_half_of_one_betters) {
  const rom::Network network = plates();
  const TestWorth worth(network, worth_options(network), short_service(network));
  for (const double length_s : {1500.0, 2400.0}) {
    const DriveLimits limits = limits_of(length_s);
    const TestPlan plan = plan_cycle(worth, limits, network.boundaries, {0});
    ASSERT_LT(plan.evaluated, 300) << "it was broken off";
    TakenReadings whole, early;
    whole.sensors = early.sensors = {0};
    early.until_s = early_s;
    const auto score_m = [](const Worth& of_whole, const Worth& of_early) {
      return std::pow(of_whole.with_sensors_m, 0.9) * std::pow(of_early.with_sensors_m, 0.1);
    };
    const std::vector<DriveCycle> others = neighbours_of(plan.cycle, limits);
    ASSERT_GE(others.size(), 4U);
    for (const DriveCycle& other : others) {
      const TestPrediction test = worth.linearise(schedule_of(other, limits, network.boundaries));
      EXPECT_GE(score_m(worth.of(test, whole), worth.of(test, early)), 0.9995 * score_m(plan.worth, plan.early))
          << length_s;
    }
  }
}

TEST(PlanTest, temporary_sensors_are_the_best_of_all_and_what_each_tells_is_what_is_lost_without_it) {
  const rom::Network network = plates();
  const TestWorth worth(network, worth_options(network), short_service(network));
  const TestPrediction test = worth.linearise(schedule_of({{1800.0, top_rpm}}, limits_of(1800.0), network.boundaries));
  TestPlan plan;
  plan_sensors(worth, test, {0}, 2, 5, plan);
  ASSERT_EQ(plan.temporary.size(), 2u) << "there are two places only";
  ASSERT_EQ(plan.candidates.size(), 2u);
  EXPECT_LE(plan.candidates[0].worth.with_sensors_m, plan.candidates[1].worth.with_sensors_m);
  EXPECT_EQ(plan.temporary[0].sensor, plan.candidates[0].sensor);
  ASSERT_EQ(plan.without.size(), 3u);
  for (const SensorWorth& one : plan.without) {
    EXPECT_GE(one.worth.with_sensors_m, plan.temporary[1].worth.with_sensors_m);
  }
  EXPECT_EQ(plan.without[2].worth.with_sensors_m, plan.temporary[0].worth.with_sensors_m);
}

TEST(PlanTest, a_day_of_work_is_four_hours_from_standstill_to_the_top_at_half_load) {
  const rom::Schedule day = usual_service(top_rpm, plates().boundaries);
  EXPECT_EQ(day.end_s, 4.0 * 3600.0);
  double least_rpm = top_rpm, most_rpm = 0.0, longest_s = 0.0;
  for (std::size_t i = 0; i + 1 < day.rows.size(); ++i) {
    const rom::OperatingState& state = day.rows[i].state;
    least_rpm = std::min(least_rpm, state.speed_rpm);
    most_rpm = std::max(most_rpm, state.speed_rpm);
    longest_s = std::max(longest_s, day.rows[i + 1].time_s - day.rows[i].time_s);
    EXPECT_EQ(state.load, state.speed_rpm > 0.0 ? 0.5 : 0.0) << i;
  }
  EXPECT_EQ(least_rpm, 0.0);
  EXPECT_EQ(most_rpm, top_rpm);
  EXPECT_LT(longest_s, 3600.0) << "shorter than a spindle takes to settle";
}

TEST(PlanTest, the_spectrum_goes_up_to_the_top_and_stands_still_and_ends_in_time) {
  const DriveCycle cycle = spectrum_cycle(limits_of(1000.0));
  double length_s = 0.0;
  for (const Stage& stage : cycle) length_s += stage.length_s;
  EXPECT_NEAR(length_s, 1000.0, 1e-9);
  EXPECT_EQ(cycle[3].speed_rpm, top_rpm);
  EXPECT_EQ(cycle[4].speed_rpm, 0.0);
  EXPECT_EQ(joined({{1.0, 5.0}, {2.0, 5.0}, {3.0, 0.0}}), (DriveCycle{{3.0, 5.0}, {3.0, 0.0}}));
}

TEST(PlanTest, a_network_without_a_length_is_refused) {
  rom::Network network = plates();
  const rom::Schedule service = short_service(network);
  WorthOptions options = worth_options(network);
  options.probe = 7;
  EXPECT_THROW(TestWorth(network, options, service), rom::InputError);
}

}  // namespace plan_test_plan_test_test
}  // namespace spindle_twin::correction::test
