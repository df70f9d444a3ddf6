#include "correction/calibrate/unknowns.hpp"

#include <gtest/gtest.h>

#include "correction/estimator/estimator_correction.hpp"
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

}  // namespace calibrate_unknowns_test
}  // namespace spindle_twin::correction::test
