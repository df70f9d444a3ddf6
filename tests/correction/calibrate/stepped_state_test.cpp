#include "correction/calibrate/stepped_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace stepped_state_test {

constexpr double gamma = 1.0 - 1.0 / std::numbers::sqrt2;
constexpr double tau_s = 300.0, heat_W = 60.0, start_rise_K = 20.0;

/// A body with 1 W/K to an ambient at the reference temperature and friction, whose heat falls by β per kelvin.
struct Friction {
  double fall_per_K = 0.0;

  double rate_K_per_s(double rise_K) const { return (heat_W * std::exp(-fall_per_K * rise_K) - rise_K) / tau_s; }
  /// The rise Y = from + weight f(Y), by bisection: the right side falls with Y.
  double stage_K(double from_K, double weight_s) const {
    double low = -1e3, high = 1e3;
    for (int halving = 0; halving < 100; ++halving) {
      const double middle = 0.5 * (low + high);
      (middle < from_K + weight_s * rate_K_per_s(middle) ? low : high) = middle;
    }
    return low;
  }
  /// One step of SDIRK2, as the header writes it.
  double step_K(double rise_K, double period_s) const {
    const double first = stage_K(rise_K, gamma * period_s);
    return stage_K(rise_K + (1.0 - gamma) / gamma * (first - rise_K), gamma * period_s);
  }
};

}  // namespace stepped_state_test

using namespace stepped_state_test;

// The first steps are longer than the body's time constant, so that the heat changes by half within one; three have the
// same length, for which Newton may keep its matrix.
TEST(SteppedState, stages_are_solved_to_a_nanokelvin) {
  rom::Network network = node_network(tau_s, heat_W);
  network.boundaries.sources.front().friction = true;
  const ParameterModel parameters(network, {});
  Eigen::VectorXd theta = parameters.neutral();
  ASSERT_GE(parameters.bearing(), 0);
  ASSERT_GE(parameters.starts(), 1);
  theta[parameters.bearing()] = 0.03;
  theta[parameters.start()] = start_rise_K;
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
  SteppedState state(network, coordinates, parameters, theta);
  state.start(ambient_K);

  const Friction friction{theta[parameters.bearing()]};
  Eigen::VectorXd temperature_K(1);
  double expected_K = start_rise_K;
  for (const double period_s : {3000.0, 700.0, 20.0, 20.0, 20.0, 5.0}) {
    expected_K = friction.step_K(expected_K, period_s);
    ASSERT_TRUE(state.advance(period_s, network.boundaries.operating));
    coordinates->to_temperatures(state.x(), temperature_K);
    EXPECT_NEAR(temperature_K[0] - ambient_K, expected_K, 1e-9) << "after a step of " << period_s << " s";
  }
}

TEST(SteppedState, of_one_body_whose_friction_falls_knows_how_it_follows_its_heat_and_its_start) {
  rom::Network network = node_network(tau_s, heat_W);
  network.boundaries.sources.front().friction = true;
  const ParameterModel parameters(network, {});
  Eigen::VectorXd theta = parameters.neutral();
  theta[parameters.bearing()] = 0.03;
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
  const auto after = [&](const Eigen::VectorXd& at) {
    SteppedState state(network, coordinates, parameters, at);
    state.start(ambient_K);
    for (const double period_s : {100.0, 200.0, 200.0}) {
      EXPECT_TRUE(state.advance(period_s, network.boundaries.operating));
    }
    return state;
  };
  const Eigen::VectorXd slope = after(theta).sensitivities().row(0).transpose();
  for (const int slot : {parameters.heat(0), parameters.bearing(), parameters.start(), parameters.conductance(0)}) {
    constexpr double step = 1e-4;
    Eigen::VectorXd above = theta, below = theta;
    above[slot] += step;
    below[slot] -= step;
    const double difference = (after(above).x()[0] - after(below).x()[0]) / (2.0 * step);
    EXPECT_NEAR(slope[slot], difference, 1e-5 * std::abs(difference)) << slot;
    EXPECT_GT(std::abs(difference), 1e-3) << slot;
  }
}

// A heat that grows by e^(0.05/K) of its rise runs away in long steps: in one of 100 s from 5 K the first stage still
// has a solution near 17 K, from which the second one begins at 34 K.
TEST(SteppedState, says_so_where_only_the_second_stage_has_no_solution) {
  rom::Network network = node_network(tau_s, heat_W);
  network.boundaries.sources.front().friction = true;
  const ParameterModel parameters(network, {});
  Eigen::VectorXd theta = parameters.neutral();
  theta[parameters.bearing()] = -0.05;
  theta[parameters.start()] = 5.0;
  const Friction growing{-0.05};
  for (const double period_s : {20.0, 100.0}) {
    SteppedState state(network, std::make_shared<const rom::NetworkOperator>(network), parameters, theta);
    state.start(ambient_K);
    const auto solution_K = [&](double from_K) {  // the lowest, or 200 K
      double rise_K = from_K;
      while (rise_K < 200.0 && from_K + gamma * period_s * growing.rate_K_per_s(rise_K) > rise_K) rise_K += 0.001;
      return rise_K;
    };
    const double first_K = solution_K(5.0);
    ASSERT_LT(first_K, 199.0);
    const bool solvable = solution_K(5.0 + (1.0 - gamma) / gamma * (first_K - 5.0)) < 199.0;
    EXPECT_EQ(solvable, period_s < 50.0);
    EXPECT_EQ(state.advance(period_s, network.boundaries.operating), solvable) << period_s;
  }
}

TEST(SteppedState, says_so_where_a_stage_has_no_solution) {
  const rom::Network network = node_network(tau_s, heat_W);
  const ParameterModel parameters(network, {});
  SteppedState state(network, std::make_shared<const rom::NetworkOperator>(network), parameters, parameters.neutral());
  state.start(ambient_K);
  rom::OperatingState unknown = network.boundaries.operating;
  unknown.environment_K.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(state.advance(20.0, unknown));
}

}  // namespace spindle_twin::correction::test
