#include "correction/calibrate/unknowns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"
#include "tests/rom/law_network.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_unknowns_test {

TEST(TestUnknowns, lags_begin_as_they_are_said_with_the_deviation_of_the_options) {
  const rom::Network network = rom::tests::make_network_with_laws();
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  for (EstimatorSensor& sensor : options.sensors) sensor.lag_s = 9.0;
  options.lag_deviation_s = 7.0;
  const ParameterModel parameters(network, options.priors);
  const TestUnknowns unknowns(network, parameters, options, 2);
  const auto first = static_cast<Eigen::Index>(unknowns.machine().size());
  ASSERT_FALSE(options.sensors.empty());
  for (std::size_t s = 0; s < options.sensors.size(); ++s) {
    const Eigen::Index at = first + static_cast<Eigen::Index>(s);
    EXPECT_EQ(unknowns.mean()[at], 9.0);
    EXPECT_NEAR(unknowns.root().row(at).norm(), 7.0, 1e-12);
  }
}

TEST(TestUnknowns, offsets_of_each_test_stand_behind_that_tests_own_unknowns_and_none_is_anothers) {
  const rom::Network network = rom::tests::make_network_with_laws();
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  const ParameterModel parameters(network, options.priors);
  constexpr std::size_t tests = 3;
  const TestUnknowns unknowns(network, parameters, options, tests);
  const auto sensors = static_cast<int>(options.sensors.size());
  const int channels = sensors + static_cast<int>(network.deformations.size());
  ASSERT_GT(channels, sensors);
  const Eigen::Index shared = static_cast<Eigen::Index>(unknowns.machine().size()) + sensors;
  const Eigen::Index each = (unknowns.count() - shared) / static_cast<Eigen::Index>(tests);
  EXPECT_EQ(shared + static_cast<Eigen::Index>(tests) * each, unknowns.count());
  const Eigen::VectorXd places =
      Eigen::VectorXd::LinSpaced(unknowns.count(), 0.0, static_cast<double>(unknowns.count() - 1));
  for (std::size_t test = 0; test < tests; ++test) {
    for (int channel = 0; channel < channels; ++channel) {
      const auto expected =
          static_cast<double>(shared + static_cast<Eigen::Index>(test + 1) * each - channels + channel);
      EXPECT_NEAR(unknowns.offset(places, test, channel), expected, 1e-9) << test << " " << channel;
      if (channel >= sensors) continue;
      const double deviation_K = options.sensors[static_cast<std::size_t>(channel)].offset_deviation_K;
      EXPECT_NEAR(unknowns.root().row(static_cast<Eigen::Index>(expected)).norm(), deviation_K, 1e-12);
    }
  }
}

TEST(TestUnknowns, begin_at_the_means_and_covariances_of_the_priors_once_for_the_machine_and_in_each_test) {
  const rom::Network network = rom::tests::make_network_with_laws();
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  options.priors.heat_common = 0.3;  // so that heats are correlated
  const ParameterModel parameters(network, options.priors);
  const TestUnknowns unknowns(network, parameters, options, 2);
  const Eigen::MatrixXd covariance = unknowns.root() * unknowns.root().transpose(), prior = parameters.covariance();
  const std::vector<Eigen::Index>& machine = unknowns.machine();
  for (std::size_t a = 0; a < machine.size(); ++a) {
    for (std::size_t b = 0; b < machine.size(); ++b) {
      EXPECT_NEAR(covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)), prior(machine[a], machine[b]),
                  1e-12);
    }
  }
  Eigen::MatrixXd between = covariance;
  between.topLeftCorner(static_cast<Eigen::Index>(machine.size()), static_cast<Eigen::Index>(machine.size())).setZero();
  between.diagonal().setZero();
  EXPECT_LT(between.cwiseAbs().maxCoeff(), 1e-12) << "nothing else is shared";
  for (const std::size_t test : {0U, 1U}) {
    EXPECT_EQ(unknowns.theta(unknowns.mean(), test), parameters.mean());
    double start_K2 = 0.0;
    const Eigen::VectorXd row =
        unknowns.row(Eigen::VectorXd::Unit(parameters.count(), parameters.start()), test).cwiseAbs2();
    for (Eigen::Index i = 0; i < row.size(); ++i) start_K2 += row[i] * covariance(i, i);
    EXPECT_NEAR(start_K2, prior(parameters.start(), parameters.start()), 1e-12);
  }
}

/// The row of what follows theta is the derivative of it along z; other tests' unknowns and lags do not move it.
TEST(TestUnknowns, of_a_test_move_its_parameters_as_their_rows_say_and_no_other_tests) {
  const rom::Network network = rom::tests::make_network_with_laws();
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  for (EstimatorSensor& sensor : options.sensors) sensor.lag_s = 9.0;
  const ParameterModel parameters(network, options.priors);
  const TestUnknowns unknowns(network, parameters, options, 3);
  const Eigen::VectorXd along = Eigen::VectorXd::LinSpaced(parameters.count(), 1.0, 3.0);
  Eigen::VectorXd step(unknowns.count());
  for (Eigen::Index i = 0; i < step.size(); ++i) step[i] = 1e-3 * std::sin(1.7 * static_cast<double>(i) + 0.2);
  TestPrediction prediction;
  prediction.sensitivities.resize(2, parameters.count());
  prediction.sensitivities.row(0) = along.transpose();
  prediction.sensitivities.row(1) = -along.reverse().transpose();
  const auto sensors = static_cast<int>(options.sensors.size());
  prediction.readings = {{0.0, sensors - 1, 0.0, 0.0, 1, 0.25, 0.0}, {0.0, sensors, 0.0, 0.0, 1, 0.25, 0.0}};
  const Eigen::VectorXd moved = unknowns.mean() + step;
  const double lag_step_s = (unknowns.lag_s(moved) - unknowns.lag_s(unknowns.mean()))[sensors - 1];
  for (const std::size_t test : {0U, 1U, 2U}) {
    const Eigen::VectorXd theta_step = unknowns.theta(moved, test) - unknowns.theta(unknowns.mean(), test);
    EXPECT_GT(theta_step.cwiseAbs().minCoeff(), 0.0);
    EXPECT_NEAR(unknowns.row(along, test).dot(step), along.dot(theta_step), 1e-12);
    const Eigen::VectorXd followed = unknowns.rows(prediction, test) * step;
    EXPECT_NEAR(followed[0], along.dot(theta_step) + unknowns.offset(step, test, sensors - 1) + 0.25 * lag_step_s,
                1e-12);
    EXPECT_NEAR(followed[1], -along.reverse().dot(theta_step) + unknowns.offset(step, test, sensors), 1e-12)
        << "a probe has no lag";
  }
}

TEST(TestUnknowns, stay_within_the_limits_of_their_parameters_and_no_lag_is_below_none) {
  const rom::Network network = rom::tests::make_network_with_laws();
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  const ParameterModel parameters(network, options.priors);
  const TestUnknowns unknowns(network, parameters, options, 1);
  const Eigen::VectorXd far = Eigen::VectorXd::Constant(unknowns.count(), 1e6);
  const Eigen::VectorXd highest = unknowns.theta(far, 0), lowest = unknowns.theta(-far, 0);
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    EXPECT_EQ(highest[i], parameters.list()[static_cast<std::size_t>(i)].maximum);
    EXPECT_EQ(lowest[i], parameters.list()[static_cast<std::size_t>(i)].minimum);
  }
  EXPECT_TRUE((unknowns.lag_s(far).array() == 1e6).all());
  EXPECT_TRUE(unknowns.lag_s(-far).isZero(0.0));
}

/// The README's 0.2 and 0.01 per kelvin, where service believes less.
TEST(TestPriors, open_the_laws_that_hours_of_several_speeds_tell_and_no_unexplained_heat) {
  EstimatorPriors service;
  service.speed_exponent = service.bearing_per_K = 0.0;
  service.disturbance = service.disturbance_by_hand = 0.3;
  const EstimatorPriors of_test = test_priors(service);
  EXPECT_EQ(of_test.speed_exponent, 0.2);
  EXPECT_EQ(of_test.bearing_per_K, 0.01);
  EXPECT_EQ(of_test.disturbance, 0.0);
  EXPECT_EQ(of_test.disturbance_by_hand, 0.0);
  service.speed_exponent = 0.5;
  service.bearing_per_K = 0.03;
  EXPECT_EQ(test_priors(service).speed_exponent, 0.5);
  EXPECT_EQ(test_priors(service).bearing_per_K, 0.03);
}

TEST(StartSpread, is_what_sensors_read_off_the_start_or_the_start_off_its_surroundings) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  ThermalTest cold = record(network, parameters, parameters.mean(), {});
  const auto around_K = [](ThermalTest& test, double temperature_K) {
    for (rom::OperatingState& state : test.operating) state.environment_K.setConstant(temperature_K);
  };
  around_K(cold, cold.start_K);
  for (Eigen::Index k = 0; k < cold.measured_K.cols(); ++k) cold.measured_K(0, k) = cold.start_K;
  EXPECT_EQ(start_spread_K(cold, options), 0.0);
  ThermalTest one_off = cold;
  const EstimatorSensor& sensor = options.sensors[1];
  const double reading_K = std::hypot(sensor.noise_K, sensor.offset_deviation_K);
  one_off.measured_K(0, 1) += 2.9 * reading_K;
  EXPECT_EQ(start_spread_K(one_off, options), 0.0) << "a sensor may be so far off";
  one_off.measured_K(0, 1) = cold.start_K - 4.0;
  EXPECT_NEAR(start_spread_K(one_off, options), 4.0, 1e-9);
  ThermalTest warm = cold;
  around_K(warm, warm.start_K - 7.0);
  EXPECT_NEAR(start_spread_K(warm, options), 7.0, 1e-9);
  const TestUnknowns as_said(network, parameters, options, std::vector{cold}),
      open(network, parameters, options, std::vector{warm});
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    if (!parameters.is_start(i)) continue;
    EXPECT_GE(start_deviation_K(parameters, i, 7.0), 7.0);
    EXPECT_EQ(start_deviation_K(parameters, i, 0.0), parameters.list()[static_cast<std::size_t>(i)].deviation);
  }
  EXPECT_EQ(open.count(), as_said.count());
  EXPECT_GT(open.root().norm(), as_said.root().norm());
}

}  // namespace calibrate_unknowns_test
}  // namespace spindle_twin::correction::test
