#include "correction/calibrate/residual_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace residual_covariance_test {

TEST(ResidualCovariance, of_a_probe_its_drift_fades_with_the_time_between_and_its_noise_stands_alone) {
  const rom::Network network = plates();
  CalibrateOptions options;
  options.memory_s = 1800.0;
  options.probe_drift_m = 5e-7;
  options.probe_noise_m = 1e-6;
  const ParameterModel parameters(network, options.priors);
  TestPrediction prediction;
  for (const double time_s : {0.0, 600.0, 3600.0}) {
    TestReading reading;
    reading.channel = 0;  // no sensors: the first output
    reading.time_s = time_s;
    reading.samples = 4;
    prediction.readings.push_back(reading);
  }
  prediction.sensitivities = Eigen::MatrixXd::Zero(3, parameters.count());
  const Eigen::MatrixXd covariance_m2 = residual_covariance(prediction, parameters, options);
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double apart_s = std::abs(prediction.readings[static_cast<std::size_t>(i)].time_s -
                                      prediction.readings[static_cast<std::size_t>(k)].time_s);
      const double expected_m2 = 25e-14 * std::exp(-apart_s / 1800.0) + (i == k ? 1e-12 / 4.0 : 0.0);
      EXPECT_NEAR(covariance_m2(i, k), expected_m2, 1e-22) << i << " " << k;
    }
  }
}

/// Of two sensors and two probes: each term of the README by itself, of sensitivities that are all different.
TEST(ResidualCovariance,
     of_joints_that_wander_and_inlets_that_drift_fades_with_their_memories_and_adds_to_each_readings) {
  const rom::Network network = plates();
  CalibrateOptions options;
  options.sensors = {{"a", {}, 0.04, 0.02, 0.0}, {"b", {}, 0.08, 0.02, 0.0}};
  options.memory_s = 1800.0;
  options.priors.environment_memory_s = 700.0;
  options.priors.environment_K = 0.3;
  options.joint_wander = 0.2;
  options.sensor_error_K = 0.06;
  options.sensor_error_share = 0.03;
  options.probe_drift_m = 0.5;
  options.probe_noise_m = 0.7;
  const ParameterModel parameters(network, options.priors);
  TestPrediction prediction;
  for (const auto& [time_s, channel, rise, samples] : {std::tuple{0.0, 0, 10.0, 2},
                                                       {60.0, 1, 5.0, 3},
                                                       {60.0, 2, 0.0, 4},
                                                       {900.0, 0, 20.0, 5},
                                                       {1500.0, 3, 0.0, 1},
                                                       {2000.0, 2, 0.0, 2}}) {
    prediction.readings.push_back({time_s, channel, 0.0, rise, samples, 0.0, 0.0});
  }
  constexpr Eigen::Index count = 6;
  prediction.sensitivities.resize(count, parameters.count());
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index i = 0; i < parameters.count(); ++i) {
      prediction.sensitivities(r, i) = std::sin(1.3 * static_cast<double>(r) + 0.7 * static_cast<double>(i)) + 0.3;
    }
  }
  const Eigen::MatrixXd found = residual_covariance(prediction, parameters, options);
  ASSERT_EQ(found.rows(), count);
  ASSERT_EQ(found.cols(), count);
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const TestReading &one = prediction.readings[static_cast<std::size_t>(r)],
                        &other = prediction.readings[static_cast<std::size_t>(k)];
      const double apart_s = std::abs(one.time_s - other.time_s);
      double expected = 0.0;
      for (Eigen::Index i = 0; i < parameters.count(); ++i) {
        const ParameterKind kind = parameters.list()[static_cast<std::size_t>(i)].kind;
        const double both = prediction.sensitivities(r, i) * prediction.sensitivities(k, i);
        if (kind == ParameterKind::contact) expected += 0.2 * 0.2 * both * std::exp(-apart_s / 1800.0);
        if (kind == ParameterKind::environment) expected += 0.3 * 0.3 * both * std::exp(-apart_s / 700.0);
      }
      const bool is_probe = one.channel > 1;
      if (is_probe && one.channel == other.channel) expected += 0.5 * 0.5 * std::exp(-apart_s / 1800.0);
      if (r == k && is_probe) expected += 0.7 * 0.7 / one.samples;
      if (r == k && !is_probe) {
        const double noise_K = one.channel == 0 ? 0.04 : 0.08;
        expected += noise_K * noise_K / one.samples + 0.06 * 0.06 + std::pow(0.03 * one.rise, 2.0);
      }
      EXPECT_NEAR(found(r, k), expected, 1e-12) << r << " " << k;
    }
  }
}

}  // namespace residual_covariance_test
}  // namespace spindle_twin::correction::test
