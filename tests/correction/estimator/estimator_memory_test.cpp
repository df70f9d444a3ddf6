#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_estimator_memory_test {

/// The start is all that is unknown of the spindle, and sensors stay what they are.
EstimatorOptions nothing_but_the_start() {
  EstimatorOptions options = environments_alone();
  options.priors.environment_K = options.priors.start_shape_K = 0.0;
  options.priors.start_K = 0.2;
  options.second_pass = options.offset_walk_K_per_root_hour = 0.0;
  return options;
}

/// After a pause in which the spindle may have become warmer by up to 4 K, more at its later nodes.
struct AfterPause : Pair {
  explicit AfterPause(const rom::Network& the_network)
      : Pair(the_network, nothing_but_the_start()),
        rise_K(Eigen::VectorXd::LinSpaced(the_network.capacity_J_per_K.rows(), 0.0, 4.0)) {
    const Eigen::VectorXd& nodes_K = twin.stepper.temperatures_K();
    estimator.reset(0.0, nodes_K, operating);
    estimator.widen_start(0.0, nodes_K, rise_K);
  }
  Eigen::VectorXd rise_K;
};

TEST(PauseUnseen, half_of_the_rise_that_it_had_time_for_is_one_deviation_beside_what_was_open_before) {
  const rom::Network network = plates();
  const AfterPause pair(network);
  ASSERT_EQ(pair.estimator.parameters().start(), 0);
  EXPECT_NEAR(pair.estimator.estimate(0).deviation, 0.2, 1e-12);
  EXPECT_EQ(pair.estimator.estimate(0).value, 0.0);
  const Eigen::VectorXd deviation_K = 0.2 * pair.estimator.sensitivities_K().col(0);
  for (Eigen::Index i = 0; i < deviation_K.size(); ++i) {
    EXPECT_NEAR(deviation_K[i], std::hypot(0.5 * pair.rise_K[i], 0.2), 1e-9) << i;
  }
  EstimatorState state;
  pair.estimator.save(state);
  ASSERT_EQ(state.start.size(), 4U);
  EXPECT_EQ(state.start[0], 600.0);
  EXPECT_EQ(state.start[1], 0.0) << "it was opened now";
  EXPECT_NEAR(state.start[3], 0.2 * 0.2, 1e-15);
}

TEST(PauseUnseen, a_fifth_of_it_counts_as_unknown_besides_and_fades_within_ten_minutes) {
  const rom::Network network = plates();
  AfterPause pair(network);
  pair.valid.setConstant(false);
  for (const double until_s : {0.0, 12.0, 602.0, 1202.0}) {
    pair.run_until(until_s);
    const double seen_s = std::max(0.0, until_s - pair.cycle_s);
    const double known_K = 0.2 * network.key_points[1].row.dot(pair.estimator.sensitivities_K().col(0));
    const double missed = 0.2 * std::exp(-seen_s / 600.0);
    EXPECT_NEAR(pair.estimator.deviations().key_points_K[1], known_K * std::sqrt(1.0 + missed * missed), 1e-9 * known_K)
        << until_s;
    EXPECT_NEAR(pair.estimator.estimate(0).deviation, 0.2, 1e-9) << "it stays as open as it was";
  }
}

TEST(PauseUnseen, what_was_found_of_it_is_forgotten_within_ten_minutes) {
  const rom::Network network = plates();
  AfterPause pair(network);
  pair.plant.stepper.set_temperatures(pair.twin.stepper.temperatures_K() + 0.5 * pair.rise_K);
  pair.run_until(22.0);
  const double found = pair.estimator.estimate(0).value;
  EXPECT_NEAR(found, 0.2, 0.05) << "one deviation";
  EXPECT_LT(pair.sensor_error_K(), 0.4) << "of up to two";
  pair.valid.setConstant(false);
  pair.run_until(622.0);
  EXPECT_NEAR(pair.estimator.estimate(0).value, found * std::exp(-600.0 / 600.0), 1e-9);
}

/// So long all that is not known comes into play: outputs are judged anew in each cycle and not once a period.
TEST(PauseUnseen, and_after_a_start_deviations_are_told_anew_in_each_cycle_for_half_a_minute) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;
  Pair pair(network, options);
  pair.valid.setConstant(false);
  const auto is_told_anew = [&] {
    const double before_m = pair.estimator.deviations().deformations_m[0];
    pair.cycle();
    return pair.estimator.deviations().deformations_m[0] != before_m;
  };
  pair.cycle();
  while (pair.time_s < 30.0) EXPECT_TRUE(is_told_anew()) << pair.time_s;
  for (const double from_s : {30.0, 130.0}) {
    while (pair.time_s < from_s + 20.0) {
      const bool due = std::fmod(pair.time_s, 10.0) == 0.0;
      EXPECT_EQ(is_told_anew(), due) << pair.time_s - pair.cycle_s;
    }
    pair.run_until(100.0);
    const Eigen::VectorXd nodes_K = pair.twin.stepper.temperatures_K();
    if (from_s < 100.0) pair.estimator.widen_start(100.0, nodes_K, Eigen::VectorXd::Constant(nodes_K.size(), 1.0));
    while (from_s < 100.0 && pair.time_s < 130.0) EXPECT_TRUE(is_told_anew()) << pair.time_s;
  }
}

TEST(EstimatorState, holds_what_the_start_may_miss_and_when_it_was_opened) {
  const rom::Network network = plates();
  AfterPause pair(network);
  pair.valid.setConstant(false);
  pair.run_until(402.0);
  EstimatorState state;
  pair.estimator.save(state);
  EXPECT_NEAR(state.start[1], -400.0, 1e-9) << "so long before";
  pair.run_until(412.0);
  const double later_K = pair.estimator.deviations().key_points_K[1];
  pair.estimator.save(state);
  EstimatorCorrection later(network, nothing_but_the_start());
  later.reset(0.0, pair.twin.stepper.temperatures_K(), pair.operating);
  ASSERT_TRUE(later.restore(state));
  EXPECT_NEAR(later.deviations().key_points_K[1], later_K, 1e-9 * later_K) << "on another clock";
}

}  // namespace estimator_estimator_memory_test
}  // namespace spindle_twin::correction::test
