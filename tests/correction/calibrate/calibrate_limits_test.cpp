#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "correction/calibrate/calibrate.hpp"
#include "tests/correction/calibrate/fitted_node.hpp"

/// What a calibration of one node is judged by, and what it says of itself.
namespace spindle_twin::correction::test {
namespace calibrate_calibrate_limits_test {

constexpr CalibrateLimits without_limits{1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 0.0, 0.0};

struct CalibratedNode : testing::Test {
  CalibratedNode() : predictor(node.network, node.options) { node.read(predictor, 0.15, 2e-6); }
  CalibrationResult judged(const CalibrateLimits& limits) const {
    return calibrate(node.network, node.options, node.tests, limits);
  }
  FittedNode node;
  TestPredictor predictor;
};

TEST(CalibrationLimits, are_those_that_are_stated) {
  const CalibrateLimits limits;
  EXPECT_EQ(limits.held_out_m, 2e-6);
  EXPECT_EQ(limits.chi_square, 1.15);
  EXPECT_EQ(limits.held_out_mean, 3.0);
  EXPECT_EQ(limits.times_expected, 3.0);
  EXPECT_EQ(limits.asked_before, 3.0);
  EXPECT_EQ(limits.asked_after, 1.0);
  EXPECT_EQ(limits.asked_heat, 4.0);
  EXPECT_EQ(limits.asked_heat_alone, 8.0);
  EXPECT_EQ(limits.asked_share, 0.01);
  EXPECT_EQ(limits.shortest_s, 1200.0);
  const DriftOptions drift;
  EXPECT_EQ(drift.heat, 0.05);
  EXPECT_EQ(drift.contact, 0.10);
  EXPECT_EQ(drift.film, 0.05);
}

TEST_F(CalibratedNode, names_what_is_beyond_a_limit_and_nothing_that_is_at_it) {
  const CalibrationResult result = judged(without_limits);
  EXPECT_TRUE(result.misfits.empty()) << result.misfits.front();
  EXPECT_TRUE(result.calibration.accepted);
  const auto misfits = [&](double CalibrateLimits::*limit, double value) {
    CalibrateLimits limits = without_limits;
    limits.*limit = value;
    const CalibrationResult found = judged(limits);
    EXPECT_EQ(found.calibration.accepted, found.misfits.empty());
    return found.misfits;
  };
  EXPECT_TRUE(misfits(&CalibrateLimits::shortest_s, result.calibration.tested_s).empty());
  EXPECT_EQ(misfits(&CalibrateLimits::shortest_s, 1.001 * result.calibration.tested_s).size(), 1U);
  const double chi_square = result.fit.chi_square_per_reading;
  EXPECT_TRUE(misfits(&CalibrateLimits::chi_square, chi_square).empty());
  ASSERT_EQ(misfits(&CalibrateLimits::chi_square, 0.999 * chi_square).size(), 1U);
  ASSERT_EQ(result.held_out.channels.size(), 4U) << "a sensor and a probe in each of two tests";
  double worst_m = 0.0, worst_share = 0.0, farthest = 0.0;
  for (const ChannelFit& channel : result.held_out.channels) {
    if (channel.channel == 1) worst_m = std::max(worst_m, channel.rms);
    worst_share = std::max(worst_share, channel.rms / channel.expected_rms);
    farthest = std::max(farthest, std::abs(channel.held_out->off) / channel.held_out->deviation);
  }
  EXPECT_TRUE(misfits(&CalibrateLimits::held_out_m, worst_m).empty());
  const std::vector<std::string> probe = misfits(&CalibrateLimits::held_out_m, 0.999 * worst_m);
  ASSERT_EQ(probe.size(), 1U);
  char text[400];
  std::snprintf(text, sizeof text, "nose, held out: %.2f um rms, at most %.2f um", 1e6 * worst_m, 0.999e6 * worst_m);
  EXPECT_EQ(probe[0], text);
  EXPECT_TRUE(misfits(&CalibrateLimits::times_expected, 1.001 * worst_share).empty());
  ASSERT_EQ(misfits(&CalibrateLimits::times_expected, 0.999 * worst_share).size(), 1U);
  EXPECT_TRUE(misfits(&CalibrateLimits::held_out_mean, 1.001 * farthest).empty());
  ASSERT_EQ(misfits(&CalibrateLimits::held_out_mean, 0.999 * farthest).size(), 1U);
  ASSERT_FALSE(result.asked.empty());
  const double surest = result.asked.front().deviations();
  EXPECT_TRUE(misfits(&CalibrateLimits::asked_heat_alone, surest).empty());
  EXPECT_EQ(misfits(&CalibrateLimits::asked_heat_alone, 0.999 * surest).size(), 1U);
}

TEST_F(CalibratedNode, says_of_each_channel_that_is_too_far_off_what_was_allowed_for_in_its_unit) {
  CalibrateLimits limits = without_limits;
  limits.times_expected = 0.0;
  const CalibrationResult result = judged(limits);
  ASSERT_EQ(result.misfits.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    const ChannelFit& channel = result.held_out.channels[k];
    const bool is_probe = channel.channel == 1;
    const double scale = is_probe ? 1e6 : 1.0;
    const char* unit = is_probe ? "um" : "K";
    char text[400];
    std::snprintf(text, sizeof text, "%s, held out: %.3f %s rms where the fit allows for %.3f %s",
                  is_probe ? "nose" : "body", scale * channel.rms, unit, scale * channel.expected_rms, unit);
    EXPECT_EQ(result.misfits[k], text);
  }
  limits = without_limits;
  limits.held_out_mean = 0.0;
  const CalibrationResult of_means = judged(limits);
  ASSERT_EQ(of_means.misfits.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    const bool is_probe = of_means.held_out.channels[k].channel == 1;
    const double scale = is_probe ? 1e6 : 1.0;
    const char* unit = is_probe ? "um" : "K";
    const HeldOutMean& mean = *of_means.held_out.channels[k].held_out;
    char text[400];
    std::snprintf(text, sizeof text, "%s, held out: on average %.3f %s off where the fit is sure to %.3f %s",
                  is_probe ? "nose" : "body", scale * mean.off, unit, scale * mean.deviation, unit);
    EXPECT_EQ(of_means.misfits[k], text);
  }
}

/// Four hours from cold at the described operating state; what drifts since the test counts.
TEST_F(CalibratedNode, promises_the_nose_after_the_same_hours_whatever_the_test_was) {
  for (const bool longest_first : {true, false}) {
    if (!longest_first) std::swap(node.tests[0], node.tests[1]);
    const CalibrationResult result = judged(without_limits);
    const Calibration& calibration = result.calibration;
    ThermalTest hours = node.tests[0];
    hours.time_s = {0.0, 14400.0};
    hours.operating = {node.network.boundaries.operating, node.network.boundaries.operating};
    hours.start_K = node.network.boundaries.reference_temperature_K;
    hours.measured_K = Eigen::MatrixXd::Constant(2, hours.measured_K.cols(), std::nan(""));
    hours.deformation_m = Eigen::MatrixXd::Constant(2, hours.deformation_m.cols(), std::nan(""));
    const TestUnknowns unknowns(node.network, predictor.parameters(), node.options, 1);
    Eigen::VectorXd z = unknowns.mean();
    z.head(calibration.mean.size()) = calibration.mean;
    const Eigen::VectorXd output = predictor.predict(hours, unknowns.theta(z, 0), unknowns.lag_s(z)).last_output;
    Eigen::MatrixXd covariance = calibration.root * calibration.root.transpose(), unknown = 0.0 * covariance;
    Eigen::VectorXd along(calibration.mean.size());
    for (Eigen::Index i = 0; i < along.size(); ++i) {
      const ParameterKind kind = result.machine[static_cast<std::size_t>(i)].kind;
      const bool drifts = kind == ParameterKind::heat || kind == ParameterKind::film;
      covariance(i, i) += drifts ? 0.05 * 0.05 : 0.0;
      unknown(i, i) = calibration.prior_deviation[i] * calibration.prior_deviation[i];
      const auto& list = predictor.parameters().list();
      const auto slot = std::find_if(list.begin(), list.end(), [&](const Parameter& each) {
        return each.name == calibration.names[static_cast<std::size_t>(i)];
      });
      along[i] = output[slot - list.begin()];
    }
    const double promised_m = std::sqrt(along.dot(covariance * along));
    EXPECT_GT(promised_m, 0.0);
    EXPECT_NEAR(calibration.promised_m, promised_m, 1e-9 * promised_m);
    EXPECT_NEAR(result.untested_m, std::sqrt(along.dot(unknown * along)), 1e-9 * promised_m);
    EXPECT_LT(promised_m, result.untested_m);
    EXPECT_NEAR(calibration.tested_s, 700.0, 1e-9);
    EXPECT_EQ(calibration.logs.size(), 2U);
  }
  node.network.deformations.clear();
  for (ThermalTest& test : node.tests) test.deformation_m.resize(test.measured_K.rows(), 0);
  EXPECT_EQ(judged(without_limits).calibration.promised_m, 0.0) << "of no output";
}

TEST_F(CalibratedNode, keeps_the_priors_that_it_began_with_and_what_was_predicted_with_their_means) {
  for (const std::size_t tests : {std::size_t{2}, std::size_t{1}}) {
    node.tests.resize(tests);
    const CalibrationResult result = judged(without_limits);
    const TestUnknowns unknowns(node.network, predictor.parameters(), node.options, tests);
    const Calibration& calibration = result.calibration;
    const auto count = static_cast<Eigen::Index>(unknowns.machine().size());
    ASSERT_EQ(calibration.mean.size(), count);
    EXPECT_EQ(calibration.mean, result.fit.z.head(count));
    EXPECT_EQ(calibration.prior_mean, unknowns.mean().head(count));
    const Eigen::MatrixXd covariance = calibration.root * calibration.root.transpose();
    EXPECT_LT((covariance - result.fit.covariance.topLeftCorner(count, count)).norm(), 1e-12 * covariance.norm());
    for (Eigen::Index i = 0; i < count; ++i) {
      const Parameter& parameter =
          predictor.parameters().list()[static_cast<std::size_t>(unknowns.machine()[static_cast<std::size_t>(i)])];
      EXPECT_EQ(calibration.names[static_cast<std::size_t>(i)], parameter.name);
      EXPECT_EQ(calibration.prior_deviation[i], parameter.deviation);
      EXPECT_EQ(calibration.nominal[i], parameter.nominal);
    }
    ASSERT_EQ(result.before.size(), tests);
    for (std::size_t test = 0; test < tests; ++test) {
      const TestPrediction expected =
          predictor.predict(node.tests[test], predictor.parameters().mean(), unknowns.lag_s(unknowns.mean()));
      ASSERT_EQ(result.before[test].readings.size(), expected.readings.size());
      for (std::size_t r = 0; r < expected.readings.size(); ++r) {
        EXPECT_EQ(result.before[test].readings[r].residual, expected.readings[r].residual);
      }
    }
  }
}

TEST_F(CalibratedNode, tells_how_often_the_model_has_run_and_counts_all_of_it) {
  node.options.starts = 3;
  std::map<std::string, int> told;
  const CalibrationResult result =
      calibrate(node.network, node.options, node.tests, without_limits,
                [&](const char* what, int count) { told[what] = std::max(told[what], count); });
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(result.fit.evaluations, told["fit of the first three quarters"] + told["fit of all readings"]);
  int of_starts = 0;
  for (const StartedFit& start : result.starts) of_starts += start.evaluations;
  EXPECT_EQ(told["fit of all readings"], of_starts);
}

TEST_F(CalibratedNode, names_the_first_parameter_too_where_it_is_bounded) {
  const Parameter& heat = predictor.parameters().list().front();
  ASSERT_EQ(heat.kind, ParameterKind::heat);
  for (ThermalTest& test : node.tests) {
    test.measured_K = (test.measured_K.array() - test.start_K) * 12.0 + test.start_K;
    test.deformation_m = (test.deformation_m.array() - 3e-6) * 12.0 + 3e-6;
  }
  const CalibrationResult result = judged(without_limits);
  EXPECT_EQ(result.calibration.mean[0], heat.maximum);
  ASSERT_FALSE(result.misfits.empty());
  EXPECT_TRUE(result.misfits.front().starts_with(heat.name + ": would have to be ")) << result.misfits.front();
}

}  // namespace calibrate_calibrate_limits_test
}  // namespace spindle_twin::correction::test
