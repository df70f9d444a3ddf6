#include "correction/calibrate/calibrate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "correction/calibrate/residual_covariance.hpp"
#include "rom/read/input_error.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_calibrate_test {

double true_value(const ParameterModel& parameters, const Eigen::VectorXd& truth, const std::string& name) {
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    if (parameters.list()[static_cast<std::size_t>(i)].name == name) return truth[i];
  }
  ADD_FAILURE() << "no parameter " << name;
  return 0.0;
}

TEST(Calibrate, hidden_parameters_are_found_within_their_deviations_and_the_probe_to_its_noise) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  double squares = 0.0, count = 0.0;
  for (const std::uint64_t seed : {11u, 12u, 13u, 14u}) {
    const Eigen::VectorXd truth = drawn(parameters, seed);
    RecordedRun run;
    run.seed = seed;
    const ThermalTest test = record(network, parameters, truth, run);
    const CalibrationResult result = calibrate(network, options, {test}, {});
    EXPECT_TRUE(result.misfits.empty()) << result.misfits.front();
    for (std::size_t i = 0; i < result.calibration.names.size(); ++i) {
      const auto slot = static_cast<Eigen::Index>(i);
      const double deviation = result.calibration.root.row(slot).norm();
      const double off =
          (result.calibration.mean[slot] - true_value(parameters, truth, result.calibration.names[i])) / deviation;
      EXPECT_LT(deviation, 1.001 * result.calibration.prior_deviation[slot]);
      EXPECT_LT(std::abs(off), 4.0) << "seed " << seed << ", " << result.calibration.names[i];
      squares += off * off;
      count += 1.0;
    }
    for (const ChannelFit& channel : result.fit.channels) {
      if (channel.channel < 4) continue;
      EXPECT_LT(channel.rms, 1.3e-6);
    }
    EXPECT_LT(result.calibration.promised_m, 0.3 * (test.deformation_m.maxCoeff() - test.deformation_m.minCoeff()));
  }
  EXPECT_LT(std::sqrt(squares / count), 1.5);  // wandering joints are allowed for, and these do not wander
}

TEST(Calibrate, two_tests_share_the_machine_and_not_their_zeros_and_starts) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  const Eigen::VectorXd truth = drawn(parameters, 21);
  RecordedRun first, second;
  second.zero_m = -200e-6;
  second.start_K = 4.0;
  second.seed = 2;
  const std::vector<ThermalTest> tests = {record(network, parameters, truth, first),
                                          record(network, parameters, truth, second)};
  const CalibrationResult both = calibrate(network, options, tests, {});
  const CalibrationResult alone = calibrate(network, options, {tests[0]}, {});
  EXPECT_TRUE(both.misfits.empty()) << both.misfits.front();
  EXPECT_EQ(both.calibration.names, alone.calibration.names);
  const auto spread = [](const CalibrationResult& result) { return result.calibration.root.squaredNorm(); };
  EXPECT_LT(spread(both), spread(alone));
  EXPECT_NEAR(both.calibration.tested_s, 7200.0, 1e-9);
}

TEST(Calibrate, the_same_bits_come_out_however_often_it_is_asked) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  RecordedRun other;
  other.seed = 9;
  const std::vector<ThermalTest> tests = {record(network, parameters, drawn(parameters, 31), {}),
                                          record(network, parameters, drawn(parameters, 31), other)};
  const CalibrationResult once = calibrate(network, options, tests, {});
  const CalibrationResult again = calibrate(network, options, tests, {});
  EXPECT_EQ(encode_calibration(once.calibration), encode_calibration(again.calibration));
}

TEST(Calibrate, readings_far_off_hardly_move_the_fit) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  ThermalTest test = record(network, parameters, drawn(parameters, 41), {});
  const CalibrationResult clean = calibrate(network, options, {test}, {});
  for (const Eigen::Index hit : {61, 121, 181}) test.measured_K(hit, 1) += 15.0;  // these are among the readings used
  test.deformation_m(91, 0) += 80e-6;
  const CalibrationResult hit = calibrate(network, options, {test}, {});
  std::size_t outliers = 0;
  for (const ChannelFit& channel : hit.fit.channels) outliers += channel.outliers;
  EXPECT_GE(outliers, 3u);
  const Eigen::MatrixXd assumed = residual_covariance(hit.fit.readings[0], parameters, options);
  std::size_t beyond = 0;
  for (Eigen::Index r = 0; r < assumed.rows(); ++r) {
    const double q = std::abs(hit.fit.left[0][r]) / std::sqrt(assumed(r, r));
    beyond += q > 3.0 ? 1 : 0;
    EXPECT_NEAR(hit.fit.weights[0](r, r) / assumed(r, r), q > 3.0 ? 1.0 + q * (q / 3.0 - 1.0) : 1.0,
                1e-9 * (1.0 + q * q))
        << "reading " << r << ", " << q << " deviations off";
  }
  EXPECT_EQ(outliers, beyond) << "those counted are those weighted";
  for (std::size_t i = 0; i < clean.calibration.names.size(); ++i) {
    const auto slot = static_cast<Eigen::Index>(i);
    EXPECT_LT(std::abs(hit.calibration.mean[slot] - clean.calibration.mean[slot]),
              0.5 * clean.calibration.prior_deviation[slot])
        << clean.calibration.names[i];
  }
}

TEST(Calibrate, a_probe_that_slips_is_named_by_the_part_that_was_held_out) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  ThermalTest test = record(network, parameters, drawn(parameters, 51), {});
  for (Eigen::Index k = 290; k < test.deformation_m.rows(); ++k) test.deformation_m(k, 0) += 15e-6;
  const CalibrationResult result = calibrate(network, options, {test}, {});
  ASSERT_FALSE(result.misfits.empty());
  EXPECT_FALSE(result.calibration.accepted);
  const bool named = std::any_of(result.misfits.begin(), result.misfits.end(), [&](const std::string& misfit) {
    return misfit.starts_with(network.deformations[0].name + ", held out: on average ");
  });
  EXPECT_TRUE(named) << result.misfits.front();
}

TEST(Calibrate, a_parameter_beyond_what_is_believed_is_bounded_and_named) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  Eigen::VectorXd truth = drawn(parameters, 52);
  truth[parameters.heat(1)] = 3.0;  // twenty times the described heat
  const CalibrationResult result = calibrate(network, options, {record(network, parameters, truth, {})}, {});
  const Parameter& heat = parameters.list()[static_cast<std::size_t>(parameters.heat(1))];
  EXPECT_DOUBLE_EQ(result.calibration.mean[parameters.heat(1)], heat.maximum);
  const bool named = std::any_of(result.misfits.begin(), result.misfits.end(), [&](const std::string& misfit) {
    return misfit.starts_with(heat.name + ": would have to be ");
  });
  EXPECT_TRUE(named);
}

TEST(Calibrate, a_machine_at_the_end_of_what_is_believed_of_it_is_no_misfit) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  const auto& list = parameters.list();
  const auto slope = std::find_if(list.begin(), list.end(), [](const Parameter& parameter) {
    return parameter.kind == ParameterKind::bearing_temperature;
  });
  ASSERT_NE(slope, list.end());
  int bounded = 0, named = 0;
  for (const double slope_per_K : {-0.03, -0.04, -0.05, -0.06}) {
    Eigen::VectorXd truth = drawn(parameters, 71);
    truth[slope - list.begin()] = slope_per_K;  // friction that rises with temperature
    const CalibrationResult result = calibrate(network, options, {record(network, parameters, truth, {})}, {});
    const auto& names = result.calibration.names;
    bounded += result.calibration.mean[std::find(names.begin(), names.end(), slope->name) - names.begin()] == 0.0;
    for (const std::string& misfit : result.misfits) named += misfit.starts_with(slope->name);
  }
  EXPECT_GE(bounded, 1);
  EXPECT_LT(named, bounded) << "not where the fit cannot tell it from the end";
}

TEST(Calibrate, a_test_without_any_reading_is_refused_by_its_name) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  ThermalTest test = record(network, parameters, drawn(parameters, 61), {});
  test.measured_K.setConstant(std::numeric_limits<double>::quiet_NaN());
  test.deformation_m.setConstant(std::numeric_limits<double>::quiet_NaN());
  try {
    calibrate(network, options, {test}, {});
    FAIL() << "was fitted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("recorded: has no reading"), std::string::npos) << error.what();
  }
}

/// A filter that begins with a calibration follows an output that its sensors hardly see better than one that does not.
TEST(Calibrate, a_filter_that_begins_with_it_is_surer_and_nearer_to_the_truth) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  double with_m2 = 0.0, without_m2 = 0.0;
  for (const std::uint64_t seed : {71u, 72u, 73u}) {
    const Eigen::VectorXd truth = drawn(parameters, seed);
    const CalibrationResult result = calibrate(network, options, {record(network, parameters, truth, {})}, {});
    for (const bool calibrated : {true, false}) {
      EstimatorOptions filter;
      filter.priors.disturbance = 0.0;
      if (calibrated) filter.priors.calibrated = prior_of(result.calibration, {});
      filter.sensors = {key_point_sensors(network, filter)[0]};
      Pair pair(network, filter);
      pair.noise_K = 0.02;
      pair.cycle_s = 10.0;
      ASSERT_EQ(pair.truth.size(), truth.size());
      pair.truth = truth;
      double& squares_m2 = calibrated ? with_m2 : without_m2;
      while (pair.time_s < 3600.0) {
        pair.cycle();
        squares_m2 += std::pow(pair.nose_error_m(), 2.0);
      }
    }
  }
  EXPECT_LT(std::sqrt(with_m2), 0.5 * std::sqrt(without_m2));
}

/// New bearings, say: what was calibrated is no knowledge any more.
TEST(Calibrate, a_machine_that_has_changed_far_more_than_drift_says_is_followed_all_the_same) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel parameters(network, options.priors);
  for (const std::uint64_t seed : {81u, 82u, 83u}) {
    const Eigen::VectorXd truth = drawn(parameters, seed);
    const CalibrationResult result = calibrate(network, options, {record(network, parameters, truth, {})}, {});
    for (const double change : {0.7, -0.7}) {
      EstimatorOptions filter;
      filter.priors.disturbance = 0.0;
      filter.priors.calibrated = prior_of(result.calibration, {});
      Pair pair(network, filter);
      pair.noise_K = 0.02;
      pair.cycle_s = 10.0;
      pair.truth = truth;
      pair.truth[parameters.heat(0)] += change;
      pair.truth[parameters.heat(1)] -= change;
      double squares_K2 = 0.0, count = 0.0;
      while (pair.time_s < 4.0 * 3600.0) {
        pair.cycle();
        if (pair.time_s < 900.0) continue;
        squares_K2 += std::pow(pair.sensor_error_K(), 2.0);
        count += 1.0;
      }
      EXPECT_GE(pair.estimator.loosened(), 1);
      EXPECT_LT(std::sqrt(squares_K2 / count), 0.3) << "seed " << seed << ", change " << change;
      // No sensor tells of the expansion: what the test left open of it stays.
      const double share = 0.02 + 2.0 * pair.estimator.estimate(pair.parameter("expansion")).deviation;
      EXPECT_LT(std::abs(pair.nose_error_m()), share * std::abs(pair.plant.outputs.deformations_m[0]));
    }
  }
}

}  // namespace calibrate_calibrate_test
}  // namespace spindle_twin::correction::test
