#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_estimator_loosen_test {

/// The start is all that is unknown of the spindle: one parameter, the first of its list.
EstimatorOptions start_alone(double start_K) {
  EstimatorOptions options = environments_alone();
  options.priors.environment_K = options.priors.start_shape_K = 0.0;
  options.priors.start_K = start_K;
  options.second_pass = options.offset_walk_K_per_root_hour = 0.0;
  return options;
}

std::vector<double> missed_of_start_K(const EstimatorCorrection& estimator) {
  EstimatorState state;
  estimator.save(state);
  return {state.start.begin() + 3, state.start.end()};
}

/// What one reading may be off by itself is noise and offset: 0.03 K and 0.02 K.
TEST(FirstReadings, open_the_start_where_one_of_them_is_off_by_more_than_three_of_its_deviations) {
  const rom::Network network = plates();
  const double limit_K = 3.0 * std::hypot(0.03, 0.02);
  for (const double off_K : {0.98 * limit_K, 1.02 * limit_K, -1.02 * limit_K}) {
    Pair pair(network, start_alone(0.05));
    ASSERT_EQ(pair.estimator.parameters().start(), 0);
    ASSERT_EQ(pair.estimator.parameters().count(), 1);
    pair.tamper = [&](Eigen::VectorXd& measured_K) { measured_K[1] += off_K; };
    pair.cycle();
    const bool opens = std::abs(off_K) > limit_K;
    const double deviation_K = opens ? std::abs(off_K) : 0.05;
    EXPECT_NEAR(pair.estimator.estimate(0).deviation, deviation_K, 1e-9) << off_K;
    EXPECT_NEAR(missed_of_start_K(pair.estimator)[0], opens ? 0.3 * deviation_K : 0.0, 1e-9) << off_K;
  }
}

TEST(FirstReadings, are_judged_by_the_least_sure_sensor_that_reads) {
  const rom::Network network = plates();
  EstimatorOptions options = start_alone(0.05);
  options.sensors = key_point_sensors(network, options);
  options.sensors[3].noise_K = 0.3;
  for (const bool reads : {true, false}) {
    Pair pair(network, options);
    pair.valid[3] = reads;
    pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K[1] += 0.5; };
    pair.cycle();
    EXPECT_NEAR(pair.estimator.estimate(0).deviation, reads ? 0.05 : 0.5, 1e-9) << reads;
  }
}

/// Without a reading nothing is said of the start yet; the first that come are asked, and none after them.
TEST(FirstReadings, are_asked_once_when_they_come) {
  const rom::Network network = plates();
  Pair pair(network, start_alone(0.05));
  pair.valid.setConstant(false);
  pair.run_until(302.0);
  pair.valid.setConstant(true);
  pair.cycle();
  EXPECT_NEAR(pair.estimator.estimate(0).deviation, 0.05, 1e-9) << "they are where they were expected";
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 2.0; };
  pair.cycle();
  EXPECT_LT(pair.estimator.estimate(0).deviation, 0.051);

  Pair late(network, start_alone(0.05));
  late.valid.setConstant(false);
  late.run_until(302.0);
  late.valid.setConstant(true);
  late.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 2.0; };
  late.cycle();
  EXPECT_GT(late.estimator.estimate(0).deviation, 1.9);
}

/// What the model's uniform start may miss counts beside it, and fades within ten minutes.
TEST(FirstReadings, that_open_the_start_leave_a_share_of_its_effect_unknown_for_ten_minutes) {
  const rom::Network network = plates();
  Pair pair(network, start_alone(0.05));
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 3.0; };
  pair.cycle();
  pair.valid.setConstant(false);
  double excess = 0.0;  // what the floor that this reading has shown counts, in all that follows
  for (const double until_s : {12.0, 612.0, 1212.0}) {
    pair.run_until(until_s);
    const double seen_s = until_s - pair.cycle_s;
    const double effect = network.key_points[2].row.dot(pair.estimator.sensitivities_K().col(0));
    const double known_K = effect * pair.estimator.estimate(0).deviation;
    const double missed_K = effect * 0.3 * 3.0 * std::exp(-seen_s / 600.0);
    const double deviation_K = pair.estimator.deviations().key_points_K[2];
    if (excess == 0.0) excess = deviation_K / std::hypot(known_K, missed_K);
    EXPECT_NEAR(deviation_K, excess * std::hypot(known_K, missed_K), 1e-9 * known_K) << until_s;
  }
  EXPECT_GT(excess, 1.0);
  EXPECT_LT(excess, 1.05);
}

TEST(Loosened, where_readings_are_far_off_environments_are_open_to_fifty_deviations_and_no_wider) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.run_until(600.0);
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 10.0; };
  while (pair.estimator.loosened() == 0 && pair.time_s < 1200.0) pair.cycle();
  ASSERT_EQ(pair.estimator.loosened(), 1);
  EXPECT_EQ(pair.estimator.widths().environment, 50.0) << "and not 200, for 20 K of 0.1 K";
}

TEST(Loosened, without_a_reading_environments_have_the_deviation_that_they_are_open_to) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;
  Pair pair(network, options);
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  pair.estimator.note_contradiction();
  pair.run_until(612.0);
  ASSERT_EQ(pair.estimator.loosened(), 1);
  EXPECT_NEAR(pair.estimator.estimate(pair.parameter("bias coolant")).deviation, 0.4, 1e-9);
  EXPECT_NEAR(pair.estimator.estimate(pair.parameter("bias ambient")).deviation, 0.4, 1e-9);
  for (const double missed_K : missed_of_start_K(pair.estimator)) {
    const bool uniform = missed_K == missed_of_start_K(pair.estimator).front();
    EXPECT_NEAR(missed_K, 0.3 * (uniform ? 0.2 : 0.1), 1e-9);
  }
}

/// Twice: from the deviation that the first has left.
TEST(Loosened, lengths_far_off_leave_heats_that_no_source_explains_as_wide_as_they_are_open) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;
  options.gate = 1.0;
  Pair pair(network, options);
  pair.truth = pair.estimator.parameters().mean();
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  for (int k = 0; k < 4; ++k) {
    pair.estimator.note_displacement(0, 1.0, 1e-6);
    pair.run_until(pair.time_s + 10.0);
    ASSERT_TRUE(pair.estimator.displacement_record().rejected);
    if (k == 0) continue;  // what no heat explains opens none until the next says the same
    const double open = pair.estimator.widths().disturbance;
    for (Eigen::Index group = 0; group < pair.estimator.parameters().group_count(); ++group) {
      const ParameterEstimate heat = pair.estimator.estimate(pair.estimator.parameters().disturbance(group));
      EXPECT_NEAR(heat.deviation, open * heat.prior_deviation, 1e-9 * open) << k << " " << group;
    }
  }
}

TEST(Loosened, heats_that_were_opened_count_as_open_until_they_have_faded_to_half_of_their_prior) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;
  options.period_s = 60.0;
  Pair pair(network, options);
  pair.cycle_s = 60.0;
  pair.valid.setConstant(false);
  pair.run_until(120.0);
  pair.estimator.note_change();
  pair.run_until(240.0);
  ASSERT_TRUE(pair.estimator.heats_are_open());
  bool between = false;
  while (pair.time_s < 13000.0) {
    pair.cycle();
    const double width = pair.estimator.widths().disturbance;
    EXPECT_EQ(pair.estimator.heats_are_open(), width >= 0.5) << width;
    between = between || (width > 0.6 && width < 0.9);
  }
  EXPECT_TRUE(between);
  EXPECT_FALSE(pair.estimator.heats_are_open());
}

/// By the start alone, after it has been found: what it has done is in the state, and it begins at nothing.
TEST(Loosened, a_start_that_is_the_only_unknown_begins_anew_where_the_spindle_is) {
  const rom::Network network = plates();
  Pair pair(network, start_alone(0.2));
  const Eigen::Index nodes = pair.twin.stepper.temperatures_K().size();
  pair.plant.stepper.set_temperatures(
      Eigen::VectorXd::Constant(nodes, network.boundaries.reference_temperature_K + 3.0));
  pair.run_until(302.0);
  EXPECT_NEAR(pair.estimator.estimate(0).value, 3.0, 0.1);
  EXPECT_LT(pair.sensor_error_K(), 0.05);
  pair.valid.setConstant(false);
  pair.estimator.note_contradiction();
  pair.run_until(312.0);
  ASSERT_EQ(pair.estimator.loosened(), 1);
  EXPECT_EQ(pair.estimator.estimate(0).value, 0.0);
  EXPECT_NEAR(pair.estimator.estimate(0).deviation, 0.2, 1e-9);
  EXPECT_LT(pair.sensor_error_K(), 0.05) << "no temperature has moved";
}

}  // namespace estimator_estimator_loosen_test
}  // namespace spindle_twin::correction::test
