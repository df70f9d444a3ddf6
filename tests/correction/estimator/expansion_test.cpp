#include <gtest/gtest.h>

#include <cmath>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_expansion_test {

/// What is known but the expansion: temperatures are met to the last digit.
EstimatorOptions only_expansion(double deviation) {
  EstimatorOptions options;
  EstimatorPriors& priors = options.priors;
  priors.heat = priors.contact = priors.film = priors.environment_K = priors.bearing_mean_per_K = 0.0;
  priors.bearing_per_K = priors.speed_exponent = priors.start_K = priors.disturbance = 0.0;
  priors.expansion = deviation;
  return options;
}

TEST(Expansion, that_nobody_measured_makes_every_growth_as_unsure_as_itself) {
  const rom::Network network = plates();
  Pair pair(network, only_expansion(0.05));
  pair.valid.setConstant(false);
  pair.run_until(3600.0);
  const double growth_m = pair.twin.outputs.deformations_m[0];
  ASSERT_GT(std::abs(growth_m), 1e-6);
  const Pair sure(network, only_expansion(0.0));
  EXPECT_NEAR(pair.estimator.deviations().deformations_m[0],
              std::hypot(0.05 * growth_m, sure.estimator.deviations().deformations_m[0]), 1e-3 * growth_m);
}

TEST(Expansion, of_a_touch_off_is_the_mean_of_what_was_believed_and_what_was_measured) {
  const rom::Network network = plates();
  Pair pair(network, only_expansion(0.05));
  pair.truth[pair.parameter("expansion")] = std::log(1.04);
  pair.run_until(3600.0);
  const double grown_m = pair.twin.outputs.deformations_m[0];
  const double noise_m = 0.02 * grown_m;
  pair.estimator.note_displacement(0, pair.plant.outputs.deformations_m[0], noise_m);
  pair.run_until(3630.0);
  ASSERT_TRUE(pair.estimator.displacement_record().fused);
  // Prior 0 ± 0.05, measured 0.04 ± 0.02, in a straight line.
  const ParameterEstimate found = pair.estimator.estimate(pair.parameter("expansion"));
  EXPECT_NEAR(found.value, 0.04 * 25.0 / 29.0, 1e-3);
  EXPECT_NEAR(found.deviation, 0.05 * 0.02 / std::hypot(0.05, 0.02), 1e-3);
  EXPECT_NEAR(pair.nose_error_m(), (std::exp(found.value) - 1.04) * grown_m, 2e-3 * grown_m);
  EXPECT_LT(pair.sensor_error_K(), 1e-5) << "no temperature follows a length that its expansion explains";
}

TEST(Expansion, is_told_from_a_heat_by_sensors) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[pair.parameter("expansion")] = 0.1;
  pair.truth[pair.parameter("heat bearing")] += 0.4;
  for (double until_s = 600.0; until_s <= 7200.0; until_s += 600.0) {
    pair.run_until(until_s);
    pair.estimator.note_displacement(0, pair.plant.outputs.deformations_m[0], 1e-7);
  }
  pair.run_until(7230.0);
  const ParameterEstimate expansion = pair.estimator.estimate(pair.parameter("expansion"));
  EXPECT_NEAR(expansion.value, 0.1, 2.0 * expansion.deviation);
  EXPECT_LT(expansion.deviation, 0.03) << "prior 0.05";
}

TEST(Expansion, has_no_parameter_where_nothing_grows) {
  rom::Network network = plates();
  network.deformations.clear();
  network.certificate.deformations_m.clear();
  EXPECT_EQ(ParameterModel(network, {}).expansion(), -1);
}

}  // namespace estimator_expansion_test
}  // namespace spindle_twin::correction::test
