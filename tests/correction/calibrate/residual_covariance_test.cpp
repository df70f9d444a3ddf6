#include "correction/calibrate/residual_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace residual_covariance_test
}  // namespace spindle_twin::correction::test
