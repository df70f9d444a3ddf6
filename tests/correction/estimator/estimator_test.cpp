#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>

#include "rom/read/input_error.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_estimator_test {

TEST(Estimator, equals_batch_least_squares_where_the_model_is_linear) {
  // Biases of the two environments and offsets of the sensors enter linearly; everything else is left out.
  const rom::Network network = plates();
  EstimatorOptions options = environments_alone();
  options.floor_largest_K = options.floor_K;
  options.second_pass = 0.0;  // what the updates alone come to
  options.offset_walk_K_per_root_hour = 0.0;
  options.offset_deviation_K = 0.1;
  Pair pair(network, options);
  ASSERT_EQ(pair.estimator.parameters().count(), 2);
  pair.truth << 0.4, -0.3;
  pair.offset_K << 0.05, -0.08, 0.1, 0.0;
  pair.noise_K = 0.02;
  pair.cycle_s = 10.0;  // one reading an update: the mean of several belongs to their mean time

  const Eigen::Index n = 6;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  information.diagonal() << 4.0, 4.0, 100.0, 100.0, 100.0, 100.0;
  Eigen::VectorXd weighted = Eigen::VectorXd::Zero(n);
  Model open_loop(network);  // never corrected
  std::vector<Eigen::VectorXd> residual_sums;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(4);
  int count = 0;
  while (pair.time_s < 1800.0) {
    const Eigen::VectorXd predicted_K = open_loop.outputs.key_points_K;
    const bool updated = pair.cycle().corrected;
    sum += pair.measured_K - predicted_K;
    ++count;
    if (updated) {
      const Eigen::MatrixXd sensitivities = pair.estimator.sensitivities_K();
      // The first reading stands alone, each of the following shares the error of its minute.
      const double noise = (0.03 * 0.03 / count + 0.03 * 0.03) * (pair.estimator.updates() == 1 ? 1.0 : 6.0);
      for (Eigen::Index s = 0; s < 4; ++s) {
        Eigen::VectorXd h = Eigen::VectorXd::Unit(n, 2 + s);
        h.head(2) = sensitivities.transpose() * network.key_points[static_cast<std::size_t>(s)].row;
        information += h * h.transpose() / noise;
        weighted += h * (sum[s] / count) / noise;
      }
      sum.setZero();
      count = 0;
    }
    open_loop.advance(pair.cycle_s, pair.operating, no_correction(network.boundaries));
  }
  const Eigen::MatrixXd posterior = information.inverse();
  const Eigen::VectorXd batch = posterior * weighted;
  EXPECT_LT((pair.estimator.covariance() - posterior).norm(), 1e-9 * posterior.norm());
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_NEAR(pair.estimator.estimate(i).value, batch[i], 2e-3) << i;
  for (Eigen::Index s = 0; s < 4; ++s) EXPECT_NEAR(pair.estimator.record(s).offset_K, batch[2 + s], 2e-3) << s;
}

TEST(Estimator, state_and_parameters_move_together_and_do_not_ring_after_a_heat_step) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("heat bearing")] = std::log(0.46);
  Model uncorrected(network);
  double uncorrected_K = 0.0, after_crossing_K = 0.0, before_K = 0.0;
  bool crossed = false;
  while (pair.time_s < 3600.0) {
    uncorrected.advance(pair.cycle_s, pair.operating, no_correction(network.boundaries));
    pair.cycle();
    const double true_K = pair.plant.outputs.key_points_K[0];
    const double error_K = pair.twin.outputs.key_points_K[0] - true_K;
    crossed = crossed || error_K * before_K < 0.0;
    if (crossed) after_crossing_K = std::max(after_crossing_K, std::abs(error_K));
    before_K = error_K;
    uncorrected_K = std::max(uncorrected_K, std::abs(uncorrected.outputs.key_points_K[0] - true_K));
  }
  EXPECT_GT(uncorrected_K, 1.0);
  EXPECT_LT(after_crossing_K, 0.05 * uncorrected_K);
  EXPECT_LT(pair.sensor_error_K(), 0.03);
}

TEST(Estimator, heat_and_its_state_are_right_together) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("heat motor")] += 0.5;
  pair.run_until(3600.0);
  const int motor = pair.parameter("heat motor");
  const ParameterEstimate estimate = pair.estimator.estimate(motor);
  EXPECT_LT(std::abs(estimate.value - pair.truth[motor]), 2.0 * estimate.deviation);
  EXPECT_LT(estimate.deviation, 0.5 * estimate.prior_deviation);
  const double deviation_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_LT(std::abs(pair.nose_error_m()), 2.0 * deviation_m);
}

TEST(Estimator, offsets_are_found_while_everything_has_one_temperature) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.offset_deviation_K = 0.2;
  options.priors.environment_K = 0.02;
  Pair pair(network, options);
  pair.operating.speed_rpm = 0.0;
  pair.operating.load = 0.0;
  pair.offset_K << 0.15, -0.12, 0.05, -0.2;
  pair.noise_K = 0.03;
  pair.run_until(2.0 * 3600.0);
  for (Eigen::Index s = 0; s < 4; ++s) {
    EXPECT_NEAR(pair.estimator.record(s).offset_K, pair.offset_K[s], 0.03) << s;
    EXPECT_LT(pair.estimator.record(s).offset_deviation_K, 0.04) << s;
  }
}

TEST(Estimator, a_jump_of_one_sensor_is_rejected_and_moves_nothing) {
  const rom::Network network = plates();
  Pair with(network, {}), without(network, {});
  for (Pair* pair : {&with, &without}) {
    pair->truth = pair->estimator.parameters().mean();
    pair->truth[pair->parameter("heat bearing")] -= 0.4;
    pair->run_until(1800.0);
  }
  with.tamper = [](Eigen::VectorXd& measured_K) { measured_K[1] += 5.0; };
  without.valid[1] = false;
  // From a minute on the estimate is said to contradict its readings, and gives way.
  with.run_until(1850.0);
  without.run_until(1850.0);
  EXPECT_TRUE(with.estimator.record(1).rejected);
  EXPECT_FALSE(with.estimator.record(1).fused);
  EXPECT_GT(with.estimator.record(1).test_ratio, 1.0);
  EXPECT_GE(with.estimator.record(1).rejected_in_a_row, 4);
  EXPECT_EQ(with.estimator.loosened(), 0);
  EXPECT_NEAR(with.nose_error_m(), without.nose_error_m(), 1e-9);
  with.tamper = nullptr;
  with.run_until(1900.0);
  EXPECT_TRUE(with.estimator.record(1).fused);
}

TEST(Estimator, a_lasting_jump_of_one_sensor_is_a_contradiction_after_a_minute_and_is_absorbed) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.run_until(1800.0);
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K[1] += 2.0; };
  pair.run_until(1850.0);
  EXPECT_FALSE(pair.estimator.consistency().in_doubt());
  pair.run_until(1902.0);
  EXPECT_TRUE(pair.estimator.consistency().in_doubt());
  EXPECT_EQ(pair.estimator.loosened(), 1);
  pair.run_until(2700.0);
  EXPECT_TRUE(pair.estimator.record(1).fused);
  EXPECT_LT(std::abs(pair.estimator.record(1).innovation_K), 0.1);
}

TEST(Estimator, missing_samples_widen_the_deviation_and_move_nothing) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.second_pass = 0.0;  // which goes through earlier samples
  Pair pair(network, options);
  pair.run_until(3602.0);  // just after an update
  const double before_m = pair.estimator.deviations().deformations_m[0];
  Eigen::VectorXd theta(pair.estimator.parameters().count());
  for (Eigen::Index i = 0; i < theta.size(); ++i) theta[i] = pair.estimator.estimate(i).value;
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.setConstant(std::numeric_limits<double>::quiet_NaN()); };
  pair.run_until(7200.0);
  EXPECT_GT(pair.estimator.deviations().deformations_m[0], 1.05 * before_m);
  EXPECT_TRUE(std::isnan(pair.estimator.record(0).observation_K));
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    if (pair.estimator.parameters().list()[static_cast<std::size_t>(i)].memory_s > 0.0) continue;
    EXPECT_EQ(pair.estimator.estimate(i).value, theta[i]);
  }
}

TEST(Estimator, touch_offs_narrow_the_nose_and_correct_it) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("contact contact 1")] += 1.0;
  pair.truth[pair.parameter("heat bearing")] += 0.7;
  pair.valid.tail(3).setConstant(false);
  pair.run_until(1800.0);
  const double error_m = std::abs(pair.nose_error_m()), deviation_m = pair.estimator.deviations().deformations_m[0];
  // One is taken in as far as a straight line stands for the ln factors, so a large error takes several.
  for (const double until_s : {1830.0, 1860.0, 1890.0}) {
    pair.estimator.note_displacement(0, pair.plant.outputs.deformations_m[0], 1e-8);
    const double before_m = pair.estimator.deviations().deformations_m[0];
    pair.run_until(until_s);
    EXPECT_TRUE(pair.estimator.displacement_record().fused);
    EXPECT_LT(pair.estimator.deviations().deformations_m[0], before_m);
  }
  EXPECT_LT(pair.estimator.deviations().deformations_m[0], 0.5 * deviation_m);
  EXPECT_LT(std::abs(pair.nose_error_m()), 0.2 * error_m);
}

TEST(Estimator, a_length_without_a_deviation_tells_nothing) {
  const rom::Network network = plates();
  Pair pair(network, {});
  for (const double deviation_m : {0.0, -1e-6, std::numeric_limits<double>::quiet_NaN()}) {
    pair.estimator.note_displacement(0, 1e-5, deviation_m);
    pair.cycle();
    EXPECT_FALSE(pair.estimator.displacement_record().fused) << deviation_m;
    EXPECT_TRUE(std::isfinite(pair.nose_error_m()));
  }
}

TEST(Estimator, sensors_of_different_rates_and_lags_lead_to_the_same_temperatures) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.sensors = key_point_sensors(network, options);
  options.sensors[0].lag_s = 40.0;
  Pair pair(network, options);
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("heat bearing")] -= 0.5;
  double shown_K = network.boundaries.reference_temperature_K;
  int reading = 0;
  pair.tamper = [&](Eigen::VectorXd& measured_K) {
    const double keep = std::exp(-pair.cycle_s / 40.0);
    shown_K = keep * shown_K + (1.0 - keep) * measured_K[0];
    measured_K[0] = shown_K;
    if (++reading % 15 != 0) measured_K[1] = std::numeric_limits<double>::quiet_NaN();  // one reading in 30 s
  };
  pair.run_until(2400.0);
  EXPECT_LT(pair.sensor_error_K(), 0.05);
  EXPECT_EQ(pair.estimator.record(0).rejected_in_a_row, 0);
}

TEST(Estimator, a_spindle_that_was_warmer_at_the_start_is_found_at_the_first_readings) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  const double reference_K = network.boundaries.reference_temperature_K;
  const Eigen::Index nodes = pair.twin.stepper.temperatures_K().size();
  pair.plant.stepper.set_temperatures(Eigen::VectorXd::Constant(nodes, reference_K + 0.5));
  pair.run_until(62.0);
  EXPECT_LT(pair.sensor_error_K(), 0.05);
  for (Eigen::Index s = 0; s < 4; ++s) EXPECT_TRUE(pair.estimator.record(s).fused) << s;
}

TEST(Estimator, first_readings_far_off_open_the_start_as_far_as_they_are_off_and_steady_rises_twice_as_far) {
  const rom::Network network = plates();
  for (const double warmer_K : {0.05, 5.0}) {  // within 3 deviations of a reading, and beyond
    Pair pair(network, {});
    const Eigen::Index nodes = pair.twin.stepper.temperatures_K().size();
    pair.plant.stepper.set_temperatures(
        Eigen::VectorXd::Constant(nodes, network.boundaries.reference_temperature_K + warmer_K));
    pair.cycle();
    const ParameterModel& parameters = pair.estimator.parameters();
    ASSERT_EQ(parameters.starts(), 3 + static_cast<Eigen::Index>(parameters.groups().size()));
    for (Eigen::Index i = parameters.start(); i < parameters.count(); ++i) {
      const bool steady = i == parameters.start() + 1 || i == parameters.start() + 2;
      const double prior_K = i == parameters.start() ? 0.2 : 0.05;
      const double expected_K = warmer_K < 1.0 ? prior_K : (steady ? 2.0 : 1.0) * warmer_K;
      EXPECT_NEAR(pair.estimator.estimate(i).deviation, expected_K, 1e-6 * expected_K)
          << parameters.list()[static_cast<std::size_t>(i)].name;
    }
  }
}

TEST(Estimator, switching_off_and_on_moves_no_temperature) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("heat bearing")] -= 0.5;
  pair.run_until(1200.0);
  const rom::CorrectionFactors none = no_correction(network.boundaries);
  for (; pair.time_s < 2400.0; pair.advance_plant()) {
    pair.estimator.stand_by(pair.time_s, pair.twin.stepper.temperatures_K(), pair.operating, pair.cycle_s);
    EXPECT_EQ(pair.estimator.factors().heat, none.heat);
    EXPECT_EQ(pair.estimator.factors().conductance, none.conductance);
    EXPECT_TRUE(pair.estimator.environment_bias_K().isZero());
    pair.twin.advance(pair.cycle_s, pair.operating, pair.estimator.factors());
  }
  const EstimatorStep first = pair.cycle();
  EXPECT_FALSE(first.state_corrected);
  pair.run_until(4800.0);
  EXPECT_LT(pair.sensor_error_K(), 0.05);
}

TEST(Estimator, remembers_everything_it_saved_and_refuses_another_size) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth[pair.parameter("heat motor")] = 0.4;
  pair.run_until(900.0);
  const Eigen::VectorXd& nodes_K = pair.twin.stepper.temperatures_K();
  pair.estimator.widen_start(pair.time_s, nodes_K, Eigen::VectorXd::Constant(nodes_K.size(), 2.0));
  EstimatorState state;
  pair.estimator.save(state);
  EstimatorCorrection other(network, {});
  EXPECT_FALSE(other.restore(state));  // not yet started
  other.reset(pair.time_s, pair.twin.stepper.temperatures_K(), pair.operating);
  ASSERT_TRUE(other.restore(state));
  EXPECT_EQ(other.covariance(), pair.estimator.covariance());
  EXPECT_EQ(other.sensitivities_K(), pair.estimator.sensitivities_K());
  for (Eigen::Index i = 0; i < other.parameters().count(); ++i) {
    EXPECT_EQ(other.estimate(i).value, pair.estimator.estimate(i).value);
  }
  // Of what is none of these nothing is lost either.
  EstimatorState again;
  other.save(again);
  EXPECT_EQ(again.lagged, state.lagged);
  EXPECT_EQ(again.channels, state.channels);
  ASSERT_EQ(again.start.size(), state.start.size());
  EXPECT_TRUE(std::any_of(state.start.begin() + 3, state.start.end(), [](double missed) { return missed != 0.0; }));
  for (std::size_t i = 0; i < state.start.size(); ++i) EXPECT_NEAR(again.start[i], state.start[i], 1e-9) << i;
  state.mean.pop_back();
  EXPECT_FALSE(other.restore(state));
}

TEST(Estimator, covariance_stays_positive_over_two_days_of_a_changing_programme) {
  const rom::Network network = rom::tests::make_synthetic_network({2, 2, 2, true}, 3);
  EstimatorOptions options;
  options.period_s = 60.0;
  Pair pair(network, options);
  pair.cycle_s = 60.0;
  pair.noise_K = 0.03;
  while (pair.time_s < 2.0 * 86400.0) {
    const long hour = static_cast<long>(pair.time_s / 3600.0);
    pair.operating.speed_rpm = hour % 3 == 0 ? 0.0 : 3000.0 * static_cast<double>(hour % 4);
    pair.cycle();
  }
  const Eigen::MatrixXd covariance = pair.estimator.covariance();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues()[0], 0.0);
  EXPECT_EQ(pair.estimator.failures(), 0);
  EXPECT_LT(pair.sensor_error_K(), 0.1);
}

TEST(Estimator, what_the_sensors_cannot_tell_keeps_its_prior_and_is_said) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.sensors = key_point_sensors(network, options);
  options.sensors.resize(1);
  Pair pair(network, options);
  pair.valid.conservativeResize(1);
  pair.run_until(3600.0);
  EXPECT_TRUE(pair.estimator.estimate(pair.parameter("film cavity")).undetermined());
  EXPECT_FALSE(pair.estimator.estimate(pair.parameter("heat bearing")).undetermined());
}

TEST(Estimator, options_out_of_range_are_refused_by_name) {
  const rom::Network network = plates();
  const auto refused = [&](auto change, const char* field) {
    EstimatorOptions options;
    change(options);
    try {
      const EstimatorCorrection estimator(network, options);
      ADD_FAILURE() << field;
    } catch (const rom::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  refused([](EstimatorOptions& options) { options.period_s = 0.5; }, "period_s");
  refused([](EstimatorOptions& options) { options.gate = 0.0; }, "gate");
  refused([](EstimatorOptions& options) { options.priors.contact = -1.0; }, "prior.contact");
  refused([](EstimatorOptions& options) { options.noise_K = 0.0; }, "noise_K");
}

}  // namespace estimator_estimator_test
}  // namespace spindle_twin::correction::test
