#include "rom/integrate/exact_stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace exact_stepper_test {

Network with_lumped_capacity(Network network) {
  network.capacity_J_per_K = Eigen::VectorXd(network.capacity_J_per_K.rowwise().sum()).asDiagonal();
  return network;
}

TEST(ExactStepper, a_node_that_nothing_cools_warms_by_heat_times_time_over_capacity) {
  const Network network = make_single_node();
  BoundaryValues values = operating_values(network);
  values.conductance_W_per_m2K[0] = 0.0;
  ExactStepper stepper(share(network));
  ASSERT_EQ(stepper.advance(7.0, values), StepStatus::ok);
  EXPECT_NEAR(stepper.temperatures_K()[0], 300.0 + 100.0 * 7.0 / 1000.0, 1e-10);
  values.capacity_factor = Eigen::VectorXd::Constant(1, 4.0);
  ASSERT_EQ(stepper.advance(4.0, values), StepStatus::ok);
  EXPECT_NEAR(stepper.temperatures_K()[0], 300.7 + 100.0 * 4.0 / 4000.0, 1e-10);
}

/// The film of a single segment and its liquid are one conductance: G = W (1 − exp(−hA/W)).
TEST(ExactStepper, a_node_in_a_circuit_follows_its_exponential_with_its_capacity_factor) {
  Network network = make_single_node();
  network.boundaries.environments[0].kind = EnvironmentKind::coolant;
  network.boundaries.circuits = {{"water", 0, 4000.0, {0}}};
  network.boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.005);
  BoundaryValues values = operating_values(network);
  values.capacity_factor = Eigen::VectorXd::Constant(1, 1.7);
  const double flow_W_per_K = 20.0, through_W_per_K = flow_W_per_K * (1.0 - std::exp(-25.0 / flow_W_per_K));
  ExactStepper stepper(share(network));
  for (int second = 1; second <= 100; ++second) {
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    const double rise_K = 100.0 / through_W_per_K * (1.0 - std::exp(-second * through_W_per_K / 1700.0));
    ASSERT_NEAR(stepper.temperatures_K()[0], 300.0 + rise_K, 1e-9);
  }
}

/// Periods of any lengths one after another are their sum, with a circuit and without, with factors and without.
TEST(ExactStepper, periods_of_different_length_add) {
  for (const bool circuit : {false, true}) {
    const Network network = with_lumped_capacity(circuit ? make_network_with_circuit({3, 2, 2, true}, 4)
                                                         : make_synthetic_network({3, 2, 2, true}, 4));
    for (const bool factors : {false, true}) {
      BoundaryValues values = operating_values(network);
      if (factors) values.capacity_factor = Eigen::VectorXd::LinSpaced(13, 0.6, 1.9);
      ExactStepper whole(share(network)), parts(share(network));
      ASSERT_EQ(whole.advance(13.0, values), StepStatus::ok);
      for (const double period_s : {1.0, 2.0, 2.0, 8.0}) {
        ASSERT_EQ(parts.advance(period_s, values), StepStatus::ok);
      }
      EXPECT_LT((whole.temperatures_K() - parts.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-9)
          << circuit << factors;
      EXPECT_GT((whole.temperatures_K().array() - 300.15).abs().maxCoeff(), 0.05);
    }
  }
}

/// What it keeps from a period is that of these inputs only: of those that come and go nothing is left.
TEST(ExactStepper, inputs_that_came_and_went_leave_no_trace_but_their_heat) {
  for (const bool circuit : {false, true}) {
    const Network network = with_lumped_capacity(circuit ? make_network_with_circuit({3, 2, 2, true}, 4)
                                                         : make_synthetic_network({3, 2, 2, true}, 4));
    const BoundaryValues plain = operating_values(network);
    BoundaryValues factored = plain, stiffer = plain, slower = plain;
    factored.capacity_factor = Eigen::VectorXd::LinSpaced(13, 0.6, 1.9);
    stiffer.conductance_W_per_m2K *= 1.7;
    if (circuit) slower.coolant_W_per_K *= 0.4;
    ExactStepper kept(share(network));
    Eigen::VectorXd state_K = Eigen::VectorXd::LinSpaced(13, 295.0, 320.0);
    kept.set_temperatures(state_K);
    const std::vector<const BoundaryValues*> course = {&plain,  &factored, &plain, &stiffer,
                                                       &slower, &factored, &plain, &slower};
    for (const BoundaryValues* values : course) {
      ASSERT_EQ(kept.advance(3.0, *values), StepStatus::ok);
      ExactStepper fresh(share(network));
      fresh.set_temperatures(state_K);
      ASSERT_EQ(fresh.advance(3.0, *values), StepStatus::ok);
      state_K = fresh.temperatures_K();
      ASSERT_LT((kept.temperatures_K() - state_K).lpNorm<Eigen::Infinity>(), 1e-9) << circuit;
    }
  }
}

TEST(ExactStepper, a_period_without_end_and_a_state_that_is_no_number_are_not_carried_on) {
  const Network network = make_single_node();
  const BoundaryValues values = operating_values(network);
  ExactStepper stepper(share(network));
  EXPECT_NEAR(stepper.temperatures_K()[0], 300.0, 1e-10) << "starts at the reference temperature";
  for (const double period_s : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(stepper.advance(period_s, values), StepStatus::integrator_failed) << period_s;
  }
  EXPECT_NEAR(stepper.temperatures_K()[0], 300.0, 1e-10);
  stepper.set_temperatures(Eigen::VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(stepper.advance(1.0, values), StepStatus::not_finite);
}

}  // namespace exact_stepper_test
}  // namespace spindle_twin::rom::tests
