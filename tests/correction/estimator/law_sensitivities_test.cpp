#include <gtest/gtest.h>

#include <cmath>

#include "correction/estimator/sensitivities.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "tests/rom/law_network.hpp"

namespace spindle_twin::correction {
namespace estimator_law_sensitivities_test {

/// dT/d ln q of a node whose copper loss grows by 17 % of its film per kelvin, against two runs with nudged heats.
TEST(LawSensitivities, a_heat_that_follows_its_temperature_acts_back) {
  rom::Network network = rom::tests::make_copper_node();
  std::get<rom::CopperLaw>(network.boundaries.sources[0].physics->law.parameters).rated_current_A = 30.0;
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
  const ParameterModel parameters(network, EstimatorPriors{});
  EXPECT_FALSE(parameters.is_friction(0));
  Sensitivities sensitivities(network, coordinates, parameters);
  sensitivities.start(parameters);
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  const Eigen::VectorXd theta = parameters.neutral();
  rom::CvodeStepper stepper(coordinates), above(coordinates), below(coordinates);
  for (rom::CvodeStepper* each : {&stepper, &above, &below})
    each->set_temperatures(Eigen::VectorXd::Constant(1, 300.0));
  const auto advance = [&](rom::CvodeStepper& each, double log_factor) {
    rom::CorrectionFactors factors = no_correction(network.boundaries);
    factors.heat[0] = std::exp(log_factor);
    evaluate_boundaries(network.boundaries, network.boundaries.operating, factors, values);
    ASSERT_EQ(each.advance(1.0, values), rom::StepStatus::ok);
  };
  constexpr double nudge = 1e-3;
  for (int second = 0; second < 200; ++second) {
    advance(above, nudge);
    advance(below, -nudge);
    const Eigen::VectorXd start_K = stepper.temperatures_K();
    advance(stepper, 0.0);
    coordinates->laws().at_temperatures(0.5 * (start_K + stepper.temperatures_K()), values);
    ASSERT_TRUE(sensitivities.advance({1.0, 0.0, start_K, stepper.temperatures_K(), values, theta}, parameters));
  }
  const double expected_K = (above.temperatures_K()[0] - below.temperatures_K()[0]) / (2.0 * nudge);
  EXPECT_NEAR(sensitivities.in_kelvin()(0, parameters.heat(0)), expected_K, 2e-3 * expected_K);
}

}  // namespace estimator_law_sensitivities_test
}  // namespace spindle_twin::correction
