#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/metered_stepper.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/synthetic_network.hpp"

/// What is put in, less what is given away, is what is stored; and the check of that notices where it is not so.
namespace spindle_twin::rom::tests {
namespace heat_balance_test {

/// An hour of cycles of 1 s: speed, load, surroundings and conductances jump every two minutes and tremble between.
HeatBalance after_an_hour(const Network& network, std::uint64_t seed, const CvodeSettings& settings = {}) {
  HeatBalance balance;
  MeteredStepper stepper(network, balance, settings);
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  OperatingState state = network.boundaries.operating;
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  stepper.set_temperatures(Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 295.0));
  double speed_rpm = 0.0;
  for (int second = 0; second < 3600; ++second) {
    if (second % 120 == 0) {
      speed_rpm = std::max(0.0, draw(-4000.0, 24000.0));
      state.load = draw(0.0, 1.2);
      state.environment_K[0] = draw(290.0, 305.0);
    }
    if (second % 10 == 0) {
      for (double& factor : factors.conductance) factor = std::exp(draw(-0.03, 0.03));
    }
    state.speed_rpm = speed_rpm * draw(0.9995, 1.0005);
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    EXPECT_EQ(stepper.advance(1.0, values), StepStatus::ok);
  }
  EXPECT_EQ(balance.steps, 3600);
  EXPECT_GT(balance.put_in_J, 1.0);
  return balance;
}

TEST(HeatBalance, closes_in_every_step_where_newtons_matrix_is_of_the_present_conductances) {
  CvodeSettings present;
  present.tolerated_share = 0.0;
  for (const Network& network : {make_synthetic_network({}, 3), make_synthetic_network({2, 2, 2, true}, 4)}) {
    const HeatBalance balance = after_an_hour(network, 5, present);
    EXPECT_LT(balance.share(), 1e-11);
    EXPECT_LT(balance.worst_share, 1e-9);
  }
}

/// A matrix that is kept is as good as the tolerance of a step, and errors of many steps do not add up.
TEST(HeatBalance, closes_over_an_hour_of_a_drive_cycle_as_the_daemon_integrates_it) {
  for (const Network& network : {make_synthetic_network({}, 3), make_synthetic_network({2, 2, 2, true}, 4)}) {
    EXPECT_LT(after_an_hour(network, 5).share(), 1e-8);
  }
}

/// One body of 40 s: short steps beside that, so that the quadrature is exact and what is left is CVODE's own error.
TEST(HeatBalance, closes_by_a_quadrature_that_knows_no_integrator_as_far_as_the_tolerance_of_a_step) {
  Network network = make_single_node();
  network.boundaries.sources[0].law = {};
  network.boundaries.sources[0].law.load_squared = 0.5;
  const HeatBalance balance = after_an_hour(network, 6);
  EXPECT_LT(balance.share(), 1e-9);
  EXPECT_LT(balance.share_by_quadrature(), 1e-5);
  EXPECT_NE(balance.residue_by_quadrature_J, 0.0);
}

/// The meters against heat_flows(), which knows nothing of them, at one instant.
TEST(HeatBalance, meters_rise_as_heats_and_films_say) {
  const Network network = make_synthetic_network({}, 7);
  BoundaryValues values = operating_values(network);
  const Eigen::VectorXd nodes_K =
      300.0 + 10.0 * Eigen::VectorXd::LinSpaced(network.capacity_J_per_K.rows(), 0.0, 1.0).array();
  const HeatFlows flows = heat_flows(network, network_bodies(network), values, nodes_K);
  double away_W = 0.0;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    if (network.boundaries.conductances[j].environment >= 0) {
      away_W += flows.exchange_W.col(static_cast<Eigen::Index>(j)).sum();
    }
  }
  HeatBalance balance;
  MeteredStepper stepper(network, balance);
  stepper.set_temperatures(nodes_K);
  constexpr double moment_s = 1e-4;
  ASSERT_EQ(stepper.advance(moment_s, values), StepStatus::ok);
  EXPECT_NEAR(balance.put_in_J / moment_s, values.heat_W.sum(), 1e-5 * values.heat_W.sum());
  EXPECT_NEAR(balance.given_away_J / moment_s, away_W, 1e-3 * std::abs(away_W));
}

TEST(HeatBalance, a_conduction_that_loses_heat_is_found) {
  Network network = make_synthetic_network({2, 2, 2, true}, 4);
  network.conduction_W_per_K(0, 0) += 1e-3;
  EXPECT_GT(after_an_hour(network, 5).share(), 1e-9);
}

TEST(HeatBalance, a_contact_that_loses_heat_is_found) {
  Network network = make_synthetic_network({2, 2, 2, true}, 4);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    if (network.boundaries.conductances[j].environment < 0) network.factors_m[j](0, 0) += 1e-6;
  }
  EXPECT_GT(after_an_hour(network, 5).share(), 1e-9);
}

TEST(HeatBalance, of_laws_and_circuits_it_is_not_asked) {
  EXPECT_THROW(with_meters(make_network_with_laws()), std::invalid_argument);
  EXPECT_THROW(with_meters(make_network_with_circuit({}, 1)), std::invalid_argument);
}

}  // namespace heat_balance_test
}  // namespace spindle_twin::rom::tests
