#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_estimator_update_test {

/// The floor stays at its least, and every reading is believed as far as its noise says.
EstimatorOptions with_a_fixed_floor() {
  EstimatorOptions options;
  options.second_pass = options.offset_walk_K_per_root_hour = 0.0;
  options.floor_largest_K = options.floor_K;
  return options;
}

double without_what_is_left_out_K2(int samples) { return 0.03 * 0.03 / samples + 0.03 * 0.03; }

TEST(UpdateNoise, of_an_open_lag_is_three_tenths_of_what_its_deviation_moves) {
  const rom::Network network = plates();
  EstimatorOptions options = with_a_fixed_floor();
  options.curvature = 0.0;
  Pair pair(network, options);
  pair.truth = pair.estimator.parameters().mean();
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 0.1; };  // far more than that
  pair.run_until(12.0);
  const EstimatorUpdate& made = pair.estimator.last_update();
  const Eigen::Index lags = pair.estimator.parameters().count() + 4;
  for (Eigen::Index s = 0; s < 4; ++s) {
    const double missed_K = 0.3 * 14.0 * made.rows(lags + s, s);
    EXPECT_NEAR(made.noise_K2[s], without_what_is_left_out_K2(6) + missed_K * missed_K, 1e-12) << s;
  }
  EXPECT_GT(std::abs(made.rows(lags, 0)), 1e-4) << "the first plate becomes warm";
}

/// Heats as open as the option allows leave out far more than what the readings miss.
TEST(UpdateNoise, for_what_a_straight_line_leaves_out_is_no_more_than_three_times_what_readings_miss) {
  const rom::Network network = plates();
  EstimatorOptions options = with_a_fixed_floor();
  options.curvature = 100.0;
  options.lag_deviation_s = 0.0;
  Pair pair(network, options);
  pair.truth = pair.estimator.parameters().mean();
  pair.noise_K = 0.003;
  pair.run_until(102.0);
  bool by_this_one = false, by_those_before = false;
  for (int k = 0; k < 20; ++k) {
    Eigen::Vector4d before_K2;
    for (Eigen::Index s = 0; s < 4; ++s) before_K2[s] = pair.estimator.consistency().square_K2(s);
    pair.run_until(pair.time_s + 10.0);
    const EstimatorUpdate& made = pair.estimator.last_update();
    for (Eigen::Index s = 0; s < 2; ++s) {
      const double this_K2 = made.innovation_K[s] * made.innovation_K[s];
      by_this_one = by_this_one || this_K2 > 1.5 * before_K2[s];
      by_those_before = by_those_before || before_K2[s] > 1.5 * this_K2;
      const double most_K2 = without_what_is_left_out_K2(5) + 9.0 * std::max(before_K2[s], this_K2);
      EXPECT_NEAR(made.noise_K2[s], 6.0 * most_K2, 1e-12) << s;
    }
  }
  EXPECT_TRUE(by_this_one);
  EXPECT_TRUE(by_those_before);
}

/// κ/2 (h_i σ_i²)² of each ln factor, as the header says.
TEST(UpdateNoise, of_open_ln_factors_is_the_share_of_their_bend_that_is_asked_for) {
  const rom::Network network = plates();
  for (const double curvature : {0.5, 2.0}) {
    EstimatorOptions options = with_a_fixed_floor();
    options.curvature = curvature;
    options.lag_deviation_s = 0.0;
    Pair pair(network, options);
    pair.truth = pair.estimator.parameters().mean();
    pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 0.1; };
    pair.run_until(12.0);
    const ParameterModel& parameters = pair.estimator.parameters();
    for (Eigen::Index s = 0; s < 4; ++s) {
      double left_out_K2 = 0.0;
      for (Eigen::Index i = 0; i < parameters.count(); ++i) {
        const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
        if (!bends_the_state(parameter.kind)) continue;
        const double variance =
            parameter.deviation * parameter.deviation + parameter.walk_per_root_s * parameter.walk_per_root_s * 10.0;
        left_out_K2 += 0.5 * curvature * std::pow(pair.estimator.last_update().rows(i, s) * variance, 2.0);
      }
      EXPECT_NEAR(pair.estimator.last_update().noise_K2[s], without_what_is_left_out_K2(6) + left_out_K2,
                  1e-9 * left_out_K2 + 1e-15)
          << s;
      EXPECT_GT(left_out_K2, s == 0 || s == 3 ? 1e-9 : 0.0) << s;
    }
  }
}

TEST(UpdateNoise, of_readings_that_are_worse_than_they_say_grows_by_its_floor) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;
  Pair pair(network, options);
  pair.truth = pair.estimator.parameters().mean();
  pair.noise_K = 0.15;
  pair.run_until(402.0);
  EXPECT_EQ(pair.estimator.loosened(), 0);
  double largest_K = 0.0;
  for (Eigen::Index s = 0; s < 4; ++s) largest_K = std::max(largest_K, pair.estimator.consistency().floor_K(s));
  EXPECT_GT(largest_K, 0.03001) << "above its least";
  EXPECT_LT(largest_K, 0.1);
}

/// The probe's own error is all that counts beside it: a millimetre, against the micrometres that the nose is open by.
TEST(UpdateOfALength, opens_heats_from_its_variance_on_and_widens_open_ones_from_twice_that) {
  const rom::Network network = plates();
  for (const double nis : {0.9, 1.1, 1.9, 2.1}) {
    Pair pair(network, with_a_fixed_floor());
    pair.run_until(602.0);
    pair.valid.setConstant(false);
    for (const double sign : {1.0, -1.0}) {
      const double length_m = pair.twin.outputs.deformations_m[0];
      pair.estimator.note_displacement(0, length_m + sign * 1e-3 * std::sqrt(nis), 1e-3);
      pair.run_until(pair.time_s + 10.0);
      EXPECT_EQ(pair.estimator.heats_are_open(), nis > 1.0) << nis;
      const bool again = sign < 0.0;
      const double width = nis < 1.0 ? 1e-3 : again && nis > 2.0 ? 24.0 : 8.0;
      EXPECT_NEAR(pair.estimator.widths().disturbance, width, 0.04) << nis;
    }
  }
}

TEST(UpdateOfALength, is_recorded_with_what_was_expected_of_it) {
  const rom::Network network = plates();
  Pair pair(network, with_a_fixed_floor());
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  pair.run_until(612.0);
  const Eigen::MatrixXd covariance = pair.estimator.covariance();
  const double value_m = pair.twin.outputs.deformations_m[0] + 1e-6;
  pair.estimator.note_displacement(0, value_m, 2e-6);
  pair.run_until(622.0);
  const EstimatorUpdate& made = pair.estimator.last_update();
  const SensorRecord& record = pair.estimator.displacement_record();
  EXPECT_EQ(record.observation_K, value_m);
  EXPECT_NEAR(record.innovation_K, made.displacement_m, 1e-15);
  EXPECT_GE(made.displacement_variance_m2, 4e-12);
  const double known_m2 = made.displacement_row.dot(covariance * made.displacement_row);
  EXPECT_NEAR(record.variance_K2, known_m2 + made.displacement_variance_m2, 0.02 * record.variance_K2);
  EXPECT_NEAR(record.test_ratio, record.innovation_K * record.innovation_K / (25.0 * record.variance_K2),
              1e-12 * record.test_ratio);
  EXPECT_TRUE(record.fused);
  EXPECT_EQ(pair.estimator.record(0).fused, false) << "no sensor was read";
}

/// Of a nose that no curvature bends: the row of the expansion is the length itself.
TEST(UpdateOfALength, expects_it_from_the_reference_temperature_on_and_the_row_of_the_expansion_is_the_length) {
  const rom::Network network = plates();
  EstimatorOptions options = with_a_fixed_floor();
  options.curvature = 0.0;
  Pair pair(network, options);
  pair.run_until(1200.0);
  pair.estimator.note_displacement(0, 1e-4, 1e-6);
  const Eigen::VectorXd nodes_K = pair.twin.stepper.temperatures_K();
  pair.run_until(1202.0);
  const rom::DeformationOutput& nose = network.deformations[0];
  const double rise_m =
      nose.row_m_per_K.dot(nodes_K) - nose.row_m_per_K.sum() * network.boundaries.reference_temperature_K;
  const EstimatorUpdate& made = pair.estimator.last_update();
  const double length_m = made.displacement_row[pair.parameter("expansion")];
  EXPECT_NEAR(length_m, rise_m * std::exp(made.unknowns[pair.parameter("expansion")]), 1e-12);
  EXPECT_NEAR(made.displacement_m, 1e-4 - length_m, 1e-15);
  EXPECT_EQ(made.displacement_variance_m2, 1e-12);
  EXPECT_TRUE(made.displacement_row.tail(8).isZero(0.0)) << "offsets and lags are of sensors";
}

TEST(UpdateOfASensor, that_is_rejected_counts_how_often_in_a_row_and_is_recorded_with_what_was_expected) {
  const rom::Network network = plates();
  Pair pair(network, with_a_fixed_floor());
  pair.run_until(602.0);
  double off_K = 6.0;
  pair.tamper = [&](Eigen::VectorXd& measured_K) { measured_K[2] += off_K; };
  for (const int in_a_row : {1, 2, 3}) {
    pair.run_until(pair.time_s + 10.0);
    const SensorRecord& record = pair.estimator.record(2);
    EXPECT_EQ(record.rejected_in_a_row, in_a_row);
    EXPECT_TRUE(record.rejected);
    EXPECT_FALSE(record.fused);
    EXPECT_NEAR(record.test_ratio, record.innovation_K * record.innovation_K / (25.0 * record.variance_K2),
                1e-12 * record.test_ratio);
    EXPECT_GT(record.test_ratio, 1.0);
    EXPECT_GT(record.variance_K2, pair.estimator.last_update().noise_K2[2]);
  }
  off_K = 0.0;
  pair.run_until(pair.time_s + 10.0);
  EXPECT_EQ(pair.estimator.record(2).rejected_in_a_row, 0);
  EXPECT_TRUE(pair.estimator.record(2).fused);
}

TEST(UpdateBounds, keep_every_parameter_within_its_limits_and_lags_between_none_and_two_minutes) {
  const rom::Network network = plates();
  const EstimatorCorrection estimator(network, {});
  const ParameterModel& parameters = estimator.parameters();
  const Eigen::Index lags = parameters.count() + 4;
  ASSERT_EQ(estimator.filter().size(), lags + 4);
  Eigen::VectorXd high = Eigen::VectorXd::Constant(lags + 4, 1e6), low = -high, within = estimator.filter().mean();
  within.tail(4).setConstant(119.0);
  const Eigen::VectorXd kept = within;
  for (Eigen::VectorXd* each : {&high, &low, &within}) estimator.bound(*each);
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    EXPECT_EQ(high[i], parameters.list()[static_cast<std::size_t>(i)].maximum);
    EXPECT_EQ(low[i], parameters.list()[static_cast<std::size_t>(i)].minimum);
  }
  for (Eigen::Index s = 0; s < 4; ++s) {
    EXPECT_EQ(high[parameters.count() + s], 1e6) << "an offset has no limits";
    EXPECT_EQ(high[lags + s], 120.0);
    EXPECT_EQ(low[lags + s], 0.0);
  }
  EXPECT_EQ(within, kept);
}

}  // namespace estimator_estimator_update_test
}  // namespace spindle_twin::correction::test
