#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "rom/integrate/right_hand_side.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace node_inputs_test {

/// What a person writes has capacities on the diagonal alone.
Network with_diagonal_capacity(Network network) {
  const Eigen::VectorXd lumped = network.capacity_J_per_K.rowwise().sum();
  network.capacity_J_per_K = lumped.asDiagonal();
  return network;
}

Network with_capacities_times(Network network, const Eigen::VectorXd& factor) {
  network.capacity_J_per_K = network.capacity_J_per_K * factor.asDiagonal();
  return network;
}

BoundaryValues values_of(const Network& network, const CorrectionFactors& factors) {
  OperatingState state = network.boundaries.operating;
  state.speed_rpm = 9000.0;
  state.load = 1.0;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, factors, values);
  return values;
}

BoundaryValues values_of(const Network& network) { return values_of(network, rom::no_correction(network.boundaries)); }

Eigen::VectorXd drawn(Eigen::Index size, double lowest, double highest, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(lowest, highest);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(random); });
}

double largest_difference_K(const Stepper& a, const Stepper& b) {
  return (a.temperatures_K() - b.temperatures_K()).lpNorm<Eigen::Infinity>();
}

std::unique_ptr<Stepper> make_stepper(bool cvode, const std::shared_ptr<const NetworkOperator>& shared) {
  if (cvode) return std::make_unique<CvodeStepper>(shared);
  return std::make_unique<ExactStepper>(shared);
}

/// C c dT/dt = q + p − G (T − T_env)
TEST(NodeInputs, one_node_follows_its_exponential) {
  const Network network = make_single_node();
  BoundaryValues values = values_of(network);
  values.node_heat_W = Eigen::VectorXd::Constant(1, 60.0);
  values.capacity_factor = Eigen::VectorXd::Constant(1, 1.7);
  CvodeStepper cvode(share(network));
  ExactStepper exact(share(network));
  for (int second = 1; second <= 200; ++second) {
    ASSERT_EQ(cvode.advance(1.0, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(1.0, values), StepStatus::ok);
    const double expected_K = 300.0 + (100.0 + 60.0) / 25.0 * (1.0 - std::exp(-second * 25.0 / 1700.0));
    ASSERT_NEAR(exact.temperatures_K()[0], expected_K, 1e-10);
    ASSERT_NEAR(cvode.temperatures_K()[0], expected_K, 2e-4);
  }
}

/// Laws followed inside the step: a winding whose loss grows with its temperature, with a heat besides.
TEST(NodeInputs, one_node_with_copper_meets_its_closed_form) {
  const Network network = make_copper_node();
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  factors.node_heat_W = Eigen::VectorXd::Constant(1, 40.0);
  factors.capacity_factor = Eigen::VectorXd::Constant(1, 0.6);
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, network.boundaries.operating, factors, values);
  const double cold_W = 3.0 * 100.0 * 0.4, by_K = 0.00393 * cold_W, film_W_per_K = 25.0;
  const double steady_K = (cold_W - by_K * 293.15 + 40.0 + film_W_per_K * 300.0) / (film_W_per_K - by_K);
  const double rate_per_s = (film_W_per_K - by_K) / 600.0;
  const auto shared = share(network);
  CvodeStepper stepper(shared);
  stepper.set_temperatures(Eigen::VectorXd::Constant(1, 300.0));
  for (int second = 1; second <= 300; ++second) {
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    const double expected_K = steady_K + (300.0 - steady_K) * std::exp(-rate_per_s * second);
    ASSERT_NEAR(stepper.temperatures_K()[0], expected_K, 2e-4) << second << " s";
  }
  EXPECT_NEAR(steady_temperatures_K(shared, values)[0], steady_K, 1e-9) << "a steady state has no capacity";
}

/// Factors that change on the way against networks whose capacities are really those, each from where the last ended.
TEST(NodeInputs, capacity_factors_are_the_capacities_of_another_network) {
  for (const Network& plain : {make_synthetic_network({}, 3), make_network_with_circuit({}, 4)}) {
    const Network network = with_diagonal_capacity(plain);
    const Eigen::Index n = network.capacity_J_per_K.rows();
    const auto shared = share(network);
    ASSERT_TRUE(shared->diagonal_capacity());
    CvodeStepper cvode(shared);
    ExactStepper exact(shared);
    Eigen::VectorXd start_K = exact.temperatures_K();
    BoundaryValues values = values_of(network);
    values.node_heat_W = drawn(n, -20.0, 30.0, 8);
    for (unsigned part = 0; part < 4; ++part) {
      values.capacity_factor = part == 2 ? Eigen::VectorXd(0) : drawn(n, 0.4, 2.5, part);
      const Eigen::VectorXd factor = part == 2 ? Eigen::VectorXd::Ones(n) : values.capacity_factor;
      ExactStepper changed(share(with_capacities_times(network, factor)));
      changed.set_temperatures(start_K);
      BoundaryValues without = values;
      without.capacity_factor.resize(0);
      for (int second = 0; second < 300; ++second) {
        ASSERT_EQ(cvode.advance(1.0, values), StepStatus::ok);
        ASSERT_EQ(exact.advance(1.0, values), StepStatus::ok);
        ASSERT_EQ(changed.advance(1.0, without), StepStatus::ok);
      }
      EXPECT_LT(largest_difference_K(exact, changed), 1e-8) << "part " << part;
      EXPECT_LT(largest_difference_K(cvode, changed), 1e-3) << "part " << part;
      start_K = changed.temperatures_K();
    }
    EXPECT_GT(start_K.maxCoeff() - start_K.minCoeff(), 5.0);
  }
}

/// A walk of the factors as a filter makes it every 10 s, below what counts as a jump.
TEST(NodeInputs, small_changes_keep_the_history_and_stay_exact) {
  const Network network = with_diagonal_capacity(make_synthetic_network({}, 5));
  const Eigen::Index n = network.capacity_J_per_K.rows();
  const auto shared = share(network);
  CvodeStepper cvode(shared);
  ExactStepper exact(shared);
  BoundaryValues values = values_of(network);
  values.node_heat_W = Eigen::VectorXd::Zero(n);
  values.capacity_factor = Eigen::VectorXd::Ones(n);
  for (int second = 0; second < 900; ++second) {
    if (second % 10 == 0) {
      values.capacity_factor.array() *= 1.0 + 1e-3 * drawn(n, -1.0, 1.0, static_cast<unsigned>(second)).array();
      values.node_heat_W += drawn(n, -0.05, 0.05, static_cast<unsigned>(second + 1));
    }
    ASSERT_EQ(cvode.advance(1.0, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(1.0, values), StepStatus::ok);
    // The air node of 0.3 J/K weighs next to nothing in the integrator's norm: there the kinks show most.
    ASSERT_LT(largest_difference_K(cvode, exact), 5e-3) << second << " s";
    const Eigen::VectorXd difference_K = cvode.temperatures_K() - exact.temperatures_K();
    const Eigen::VectorXd weight = network.capacity_J_per_K.diagonal() / network.capacity_J_per_K.trace();
    ASSERT_LT(std::sqrt(weight.dot(difference_K.cwiseAbs2())), 1e-4) << second << " s";
  }
  EXPECT_LE(cvode.counts().restarts, 1);
}

TEST(NodeInputs, heat_balance_closes_in_an_insulated_network) {
  const Network network = with_diagonal_capacity(make_synthetic_network({4, 4, 4, false}, 41));
  const Eigen::Index n = network.capacity_J_per_K.rows();
  BoundaryValues values = values_of(network);
  values.capacity_factor = drawn(n, 0.5, 2.0, 7);
  const Eigen::VectorXd capacity_J_per_K = network.capacity_J_per_K.diagonal().cwiseProduct(values.capacity_factor);
  for (const bool cvode : {true, false}) {
    const std::unique_ptr<Stepper> stepper = make_stepper(cvode, share(network));
    const double start_J = capacity_J_per_K.dot(stepper->temperatures_K());
    double heat_J = 0.0;
    for (unsigned second = 0; second < 900; ++second) {
      if (second % 100 == 0) values.node_heat_W = drawn(n, -5.0, 15.0, second);
      ASSERT_EQ(stepper->advance(1.0, values), StepStatus::ok);
      heat_J += values.heat_W.sum() + values.node_heat_W.sum();
    }
    ASSERT_GT(heat_J, 1e4);
    const double stored_J = capacity_J_per_K.dot(stepper->temperatures_K()) - start_J;
    EXPECT_NEAR(stored_J / heat_J, 1.0, cvode ? 1e-5 : 1e-9);
  }
}

/// dT/dt of the right-hand side against the heat that every body stores, laws followed; and its Jacobian.
TEST(NodeInputs, right_hand_side_stores_what_the_flows_leave_and_has_its_own_jacobian) {
  const Network network = with_diagonal_capacity(make_network_with_laws());
  const auto shared = share(network);
  const Eigen::Index n = shared->nodes();
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  factors.node_heat_W = drawn(n, -10.0, 30.0, 1);
  factors.capacity_factor = drawn(n, 0.5, 2.0, 2);
  const BoundaryValues values = values_of(network, factors);
  const Eigen::VectorXd temperatures_K = drawn(n, 302.0, 322.0, 3);
  RightHandSide rhs(shared);
  Eigen::VectorXd x(n), rate(n);
  shared->to_internal(temperatures_K, x);
  rhs.follow(values, x.data());
  rhs.evaluate(x.data(), rate.data());
  const Eigen::VectorXd root = shared->capacity_root().diagonal();
  const Eigen::VectorXd stored_W = root.cwiseProduct(factors.capacity_factor).cwiseProduct(rate);  // C c dT/dt
  BoundaryValues now = values;
  shared->laws().at_temperatures(temperatures_K, now);
  const std::vector<Body> bodies = network_bodies(network);
  const HeatFlows flows = heat_flows(network, bodies, now, temperatures_K);
  EXPECT_NEAR(flows.node_W.sum(), factors.node_heat_W.sum(), 1e-9);
  const double scale_W = flows.exchange_W.cwiseAbs().sum();
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    EXPECT_NEAR(stored_W(bodies[body].nodes).sum(), flows.stored_W[static_cast<Eigen::Index>(body)], 1e-11 * scale_W);
  }

  Eigen::MatrixXd analytic(n, n);
  rhs.linearise(x.data(), analytic);
  Eigen::VectorXd up(n), down(n);
  const double step = 0.01 * shared->internal_per_kelvin();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::VectorXd moved = x;
    moved[k] = x[k] + step;
    rhs.evaluate(moved.data(), up.data());
    moved[k] = x[k] - step;
    rhs.evaluate(moved.data(), down.data());
    EXPECT_LT((analytic.col(k) - (down - up) / (2.0 * step)).norm(), 1e-5 * analytic.col(k).norm()) << "column " << k;
  }
}

TEST(NodeInputs, cvode_follows_laws_with_node_inputs) {
  const Network network = with_diagonal_capacity(make_network_with_laws());
  const Eigen::Index n = network.capacity_J_per_K.rows();
  const Eigen::VectorXd factor = drawn(n, 0.5, 2.0, 2);
  BoundaryValues values = values_of(network);
  values.node_heat_W = drawn(n, -10.0, 30.0, 1);
  CvodeStepper changed(share(with_capacities_times(network, factor))), scaled(share(network));
  for (int second = 0; second < 600; ++second) {
    ASSERT_EQ(changed.advance(1.0, values), StepStatus::ok);
    values.capacity_factor = factor;
    ASSERT_EQ(scaled.advance(1.0, values), StepStatus::ok);
    values.capacity_factor.resize(0);
  }
  EXPECT_LT(largest_difference_K(changed, scaled), 1e-3);
  EXPECT_GT(scaled.temperatures_K().maxCoeff(), 305.0);
}

TEST(NodeInputs, what_does_not_fit_is_refused_and_moves_nothing) {
  const Network full = make_synthetic_network({}, 6), diagonal = with_diagonal_capacity(full);
  const Eigen::Index n = full.capacity_J_per_K.rows();
  for (const bool cvode : {true, false}) {
    const std::unique_ptr<Stepper> with_full = make_stepper(cvode, share(full));
    const std::unique_ptr<Stepper> with_diagonal = make_stepper(cvode, share(diagonal));
    const Eigen::VectorXd before_K = with_full->temperatures_K();
    BoundaryValues values = values_of(full);
    values.capacity_factor = Eigen::VectorXd::Ones(n);
    EXPECT_EQ(with_full->advance(1.0, values), StepStatus::refused) << "a capacity matrix that is not diagonal";
    EXPECT_EQ(with_full->temperatures_K(), before_K);
    for (const double bad : {0.0, -1.0}) {
      values.capacity_factor[3] = bad;
      EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::refused) << bad;
    }
    values.capacity_factor[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::not_finite);
    values.capacity_factor = Eigen::VectorXd::Ones(n - 1);
    EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::refused) << "wrong length";
    values.capacity_factor = Eigen::VectorXd::Ones(n);
    values.node_heat_W = Eigen::VectorXd::Ones(n + 1);
    EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::refused) << "wrong length";
    values.node_heat_W = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
    EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::not_finite);
    EXPECT_EQ(with_diagonal->temperatures_K(), before_K);
    values.node_heat_W.resize(0);
    EXPECT_EQ(with_diagonal->advance(1.0, values), StepStatus::ok);
  }
}

TEST(NodeInputs, boundaries_keep_the_length_that_they_had_once) {
  const Network network = make_single_node();
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  BoundaryValues values = values_of(network, factors);
  EXPECT_EQ(values.node_heat_W.size(), 0);
  EXPECT_EQ(values.capacity_factor.size(), 0);
  factors.node_heat_W = Eigen::VectorXd::Constant(1, 7.0);
  factors.capacity_factor = Eigen::VectorXd::Constant(1, 3.0);
  rom::evaluate_boundaries(network.boundaries, network.boundaries.operating, factors, values);
  EXPECT_EQ(values.node_heat_W[0], 7.0);
  EXPECT_EQ(values.capacity_factor[0], 3.0);
  rom::evaluate_boundaries(network.boundaries, network.boundaries.operating, rom::no_correction(network.boundaries),
                           values);
  EXPECT_EQ(values.node_heat_W, Eigen::VectorXd::Zero(1));
  EXPECT_EQ(values.capacity_factor, Eigen::VectorXd::Ones(1));
}

TEST(NodeInputs, no_heap_call_in_the_cycle) {
  const Network network = with_diagonal_capacity(make_network_with_laws());
  const Eigen::Index n = network.capacity_J_per_K.rows();
  const auto stepper = make_runtime_stepper(network);
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  const CorrectionFactors none = factors;
  factors.node_heat_W = Eigen::VectorXd::Zero(n);
  factors.capacity_factor = Eigen::VectorXd::Ones(n);
  OperatingState state = network.boundaries.operating;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  StepStatus status = StepStatus::ok;
  long before = heap_calls();
  for (int second = 0; second < 300 && status == StepStatus::ok; ++second) {
    if (second == 1) before = heap_calls();
    state.speed_rpm = second % 40 < 20 ? 9000.0 : 4000.0;
    if (second % 10 == 0) {
      factors.node_heat_W[second % n] += 5.0;
      factors.capacity_factor[second % n] *= second % 20 == 0 ? 1.3 : 0.9999;
    }
    // The correction is switched off now and then.
    rom::evaluate_boundaries(network.boundaries, state, second % 50 == 49 ? none : factors, values);
    status = stepper->advance(1.0, values);
  }
  EXPECT_EQ(heap_calls() - before, 0);
  EXPECT_EQ(status, StepStatus::ok);
  EXPECT_EQ(stepper->fallbacks(), 0);
}

}  // namespace node_inputs_test
}  // namespace spindle_twin::rom::tests
