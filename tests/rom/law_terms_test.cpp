#include "rom/integrate/law_terms.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/integrate/right_hand_side.hpp"
#include "rom/integrate/sensitivity.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/rom/operating_values.hpp"

namespace spindle_twin::rom::tests {
namespace law_terms_test {

/// Factors that differ from one, so that one left out shows.
CorrectionFactors uneven_factors(const Boundaries& boundaries) {
  CorrectionFactors factors = rom::no_correction(boundaries);
  for (Eigen::Index i = 0; i < factors.heat.size(); ++i) factors.heat[i] = 0.8 + 0.05 * static_cast<double>(i);
  for (Eigen::Index j = 0; j < factors.conductance.size(); ++j) {
    factors.conductance[j] = 1.3 - 0.04 * static_cast<double>(j);
  }
  return factors;
}

BoundaryValues values_at_flow(const Network& network, double flow_kg_per_s, double speed_rpm = 5200.0) {
  OperatingState state = network.boundaries.operating;
  state.speed_rpm = speed_rpm;
  state.load = 0.7;
  if (state.flow_kg_per_s.size() > 0) state.flow_kg_per_s[0] = flow_kg_per_s;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, uneven_factors(network.boundaries), values);
  return values;
}

Eigen::VectorXd warm_temperatures_K(const Network& network, unsigned seed = 5) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Eigen::VectorXd temperatures_K(network.capacity_J_per_K.rows());
  for (double& kelvin : temperatures_K) kelvin = 302.0 + 20.0 * unit(engine);
  return temperatures_K;
}

/// Column k of ∂f/∂x by a fourth-order difference.
Eigen::VectorXd difference(const RightHandSide& rhs, const Eigen::VectorXd& x, Eigen::Index k, double step) {
  Eigen::VectorXd moved = x, rate(x.size()), sum = Eigen::VectorXd::Zero(x.size());
  for (const auto& [steps, weight] : {std::pair{1.0, 8.0}, {-1.0, -8.0}, {2.0, -1.0}, {-2.0, 1.0}}) {
    moved[k] = x[k] + steps * step;
    rhs.evaluate(moved.data(), rate.data());
    sum += weight * rate;
  }
  return sum / (12.0 * step);
}

TEST(LawTerms, jacobian_is_that_of_the_right_hand_side) {
  const Network network = make_network_with_laws();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  for (const double flow_kg_per_s : {0.03, -0.013, 0.0}) {
    SCOPED_TRACE(flow_kg_per_s);
    RightHandSide rhs(shared);
    const Eigen::Index n = shared->nodes();
    Eigen::VectorXd x(n);
    shared->to_internal(Eigen::VectorXd::Constant(n, 303.0), x);
    rhs.follow(values_at_flow(network, flow_kg_per_s), x.data());  // K̃ of a colder state, as in the middle of a period
    ASSERT_TRUE(rhs.following());
    shared->to_internal(warm_temperatures_K(network), x);
    Eigen::MatrixXd held(n, n), analytic(n, n), numeric(n, n);
    rhs.linearise(x.data(), analytic);
    const double kelvin = shared->internal_per_kelvin();
    for (Eigen::Index k = 0; k < n; ++k) numeric.col(k) = -difference(rhs, x, k, 0.1 * kelvin);
    EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 1e-7 * analytic.cwiseAbs().maxCoeff());
    // The stiff air node must not hide the rest: every column against its own size.
    for (Eigen::Index k = 0; k < n; ++k) {
      EXPECT_LT((analytic.col(k) - numeric.col(k)).norm(), 1e-7 * analytic.col(k).norm()) << "column " << k;
    }
    rhs.hold(values_at_flow(network, flow_kg_per_s));
    rhs.full(held);
    EXPECT_GT((analytic - held).cwiseAbs().maxCoeff(), 1e-4 * analytic.cwiseAbs().maxCoeff()) << "laws had no effect";
  }
}

/// Zero order of the laws: at their nominal inputs they are what evaluate_boundaries holds.
TEST(LawTerms, values_at_the_nominal_temperatures_are_the_held_ones) {
  Network network = make_network_with_laws();
  const auto at_310 = [](std::optional<BoundLaw>& law) {
    if (!law) return;
    law->displacement = -1;
    law->pressure = -1;
  };
  for (HeatSource& source : network.boundaries.sources) at_310(source.physics);
  for (Conductance& conductance : network.boundaries.conductances) at_310(conductance.physics);
  const NetworkOperator coordinates(network);
  const BoundaryValues held = values_at_flow(network, 0.03);
  BoundaryValues now = held;
  coordinates.laws().at_temperatures(Eigen::VectorXd::Constant(coordinates.nodes(), 310.0), now);
  EXPECT_LT((now.heat_W - held.heat_W).cwiseAbs().maxCoeff(), 1e-9 * held.heat_W.maxCoeff());
  EXPECT_LT((now.conductance_W_per_m2K - held.conductance_W_per_m2K).cwiseAbs().maxCoeff(),
            1e-9 * held.conductance_W_per_m2K.maxCoeff());
  coordinates.laws().at_temperatures(Eigen::VectorXd::Constant(coordinates.nodes(), 330.0), now);
  EXPECT_LT(now.heat_W[2], 0.8 * held.heat_W[2]) << "a warm bearing rubs less";
  EXPECT_GT(now.heat_W[4], 1.05 * held.heat_W[4]) << "a warm winding loses more";
}

/// What the nodes store is what the sources give less what the surroundings take, at the laws' present values.
TEST(LawTerms, heat_balance_closes) {
  const Network network = make_network_with_laws();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  for (const double flow_kg_per_s : {0.03, -0.02}) {
    const BoundaryValues values = values_at_flow(network, flow_kg_per_s);
    RightHandSide rhs(shared);
    const Eigen::VectorXd temperatures_K = warm_temperatures_K(network);
    Eigen::VectorXd x(shared->nodes()), rate(shared->nodes());
    shared->to_internal(temperatures_K, x);
    rhs.follow(values, x.data());
    rhs.evaluate(x.data(), rate.data());
    const Eigen::VectorXd stored_W = shared->capacity_root().triangularView<Eigen::Lower>() * rate;  // C dT/dt
    BoundaryValues now = values;
    shared->laws().at_temperatures(temperatures_K, now);
    const HeatFlows flows = heat_flows(network, network_bodies(network), now, temperatures_K);
    const double scale_W = flows.exchange_W.cwiseAbs().sum();
    EXPECT_NEAR(stored_W.sum(), flows.stored_W.sum(), 1e-11 * scale_W);
    const double given_W = now.heat_W.sum();
    double taken_W = 0.0;
    for (std::size_t j = 0; j < network.boundaries.conductances.size(); ++j) {
      if (network.boundaries.conductances[j].environment < 0) continue;
      taken_W += flows.exchange_W.col(static_cast<Eigen::Index>(j)).sum();
    }
    EXPECT_NEAR(stored_W.sum(), given_W - taken_W, 1e-11 * scale_W);
    EXPECT_NEAR(coolant_outlets(*shared, values, temperatures_K).heat_W[0],
                coolant_outlets(*shared, now, temperatures_K).heat_W[0], 1e-9);
  }
}

/// Copper loss grows linearly with temperature, so one node has a closed answer:
///   C dT/dt = a + b (T − T_20) − G (T − T_env)
TEST(LawTerms, one_node_with_copper_meets_its_closed_form) {
  const Network network = make_copper_node();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  BoundaryValues values = operating_values(network);
  const double cold_W = 3.0 * 100.0 * 0.4, by_K = 0.00393 * cold_W, film_W_per_K = 25.0, capacity_J_per_K = 1000.0;
  const double steady_K = (cold_W - by_K * 293.15 + film_W_per_K * 300.0) / (film_W_per_K - by_K);
  const double rate_per_s = (film_W_per_K - by_K) / capacity_J_per_K;
  CvodeStepper stepper(shared);
  stepper.set_temperatures(Eigen::VectorXd::Constant(1, 300.0));
  for (int second = 1; second <= 300; ++second) {
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    const double exact_K = steady_K + (300.0 - steady_K) * std::exp(-rate_per_s * second);
    EXPECT_NEAR(stepper.temperatures_K()[0], exact_K, 2e-4) << second << " s";
  }
  EXPECT_NEAR(steady_temperatures_K(shared, values)[0], steady_K, 1e-9);
  // Laws held would end where the loss at 300 K leads, 2 % lower.
  values.laws.follow = false;
  EXPECT_NEAR(steady_temperatures_K(shared, values)[0], 300.0 + values.heat_W[0] / film_W_per_K, 1e-9);
}

/// C dT/dt = −(K₀ + Σ g F Fᵀ) T + … as it stands in the network, laws by evaluate(), Runge-Kutta of order 4.
Eigen::VectorXd independent_K(const Network& network, BoundaryValues values, Eigen::VectorXd temperatures_K,
                              double end_s, int steps) {
  const Eigen::PartialPivLU<Eigen::MatrixXd> capacity(network.capacity_J_per_K);
  const NetworkOperator coordinates(network);
  const auto rate = [&](const Eigen::VectorXd& at_K) -> Eigen::VectorXd {
    coordinates.laws().at_temperatures(at_K, values);
    Eigen::VectorXd heat_W = network.source_distribution * values.heat_W - network.conduction_W_per_K * at_K;
    for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
      Eigen::VectorXd jump_K = network.factors_m[j].transpose() * at_K;
      const int environment = network.boundaries.conductances[j].environment;
      if (environment >= 0) {
        jump_K -= values.environment_K[environment] * network.factors_m[j].colwise().sum().transpose();
      }
      heat_W -= values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * (network.factors_m[j] * jump_K);
    }
    return capacity.solve(heat_W);
  };
  const double h = end_s / steps;
  for (int k = 0; k < steps; ++k) {
    const Eigen::VectorXd k1 = rate(temperatures_K), k2 = rate(temperatures_K + 0.5 * h * k1),
                          k3 = rate(temperatures_K + 0.5 * h * k2), k4 = rate(temperatures_K + h * k3);
    temperatures_K += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return temperatures_K;
}

TEST(LawTerms, cvode_meets_an_independent_integration_and_converges_with_its_tolerance) {
  Network network = make_network_with_laws();
  network.boundaries.circuits.clear();  // the independent model knows no liquid that warms up
  network.boundaries.operating.flow_kg_per_s.resize(0);
  for (Conductance& conductance : network.boundaries.conductances) {
    if (conductance.physics && conductance.physics->circuit >= 0) conductance.physics.reset();
  }
  const auto shared = std::make_shared<const NetworkOperator>(network);
  const BoundaryValues values = values_at_flow(network, 0.0);
  const Eigen::VectorXd start_K = Eigen::VectorXd::Constant(shared->nodes(), 300.15);
  constexpr double end_s = 600.0;
  const Eigen::VectorXd expected_K = independent_K(network, values, start_K, end_s, 9000);
  EXPECT_LT((expected_K - independent_K(network, values, start_K, end_s, 6000)).cwiseAbs().maxCoeff(), 1e-6);
  double before_K = 0.0;
  for (const double tolerance_K : {2e-3, 2e-4, 2e-5, 2e-6}) {
    CvodeSettings settings;
    settings.tolerance_K = tolerance_K;
    CvodeStepper stepper(shared, settings);
    stepper.set_temperatures(start_K);
    ASSERT_EQ(stepper.advance(end_s, values), StepStatus::ok);
    const double error_K = (stepper.temperatures_K() - expected_K).cwiseAbs().maxCoeff();
    std::printf("tolerance %.0e K: %.2e K off after 600 s, %ld steps, %ld decompositions\n", tolerance_K, error_K,
                stepper.counts().internal_steps, stepper.counts().decompositions);
    if (before_K > 0.0) {
      EXPECT_LT(error_K, 0.3 * before_K);
    }
    before_K = error_K;
  }
  EXPECT_LT(before_K, 5e-5);
  // What the laws are worth here: held at the start they miss by far more than any tolerance.
  BoundaryValues held = values;
  shared->laws().at_temperatures(start_K, held);
  held.laws.follow = false;
  CvodeStepper cold(shared);
  cold.set_temperatures(start_K);
  ASSERT_EQ(cold.advance(end_s, held), StepStatus::ok);
  EXPECT_GT((cold.temperatures_K() - expected_K).cwiseAbs().maxCoeff(), 0.05);
}

/// The fallback holds laws over a period: an error of first order in the period.
TEST(LawTerms, exact_stepper_is_of_first_order_in_the_period) {
  const Network network = make_network_with_laws();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  const BoundaryValues values = values_at_flow(network, 0.03);
  const Eigen::VectorXd start_K = Eigen::VectorXd::Constant(shared->nodes(), 300.15);
  CvodeSettings settings;
  settings.tolerance_K = 1e-9;
  CvodeStepper reference(shared, settings);
  reference.set_temperatures(start_K);
  for (int k = 0; k < 16; ++k) ASSERT_EQ(reference.advance(1.0, values), StepStatus::ok);
  std::vector<double> errors_K;
  for (const int periods : {8, 16, 32}) {
    ExactStepper exact(shared);
    exact.set_temperatures(start_K);
    for (int k = 0; k < periods; ++k) ASSERT_EQ(exact.advance(16.0 / periods, values), StepStatus::ok);
    errors_K.push_back((exact.temperatures_K() - reference.temperatures_K()).cwiseAbs().maxCoeff());
  }
  EXPECT_NEAR(errors_K[0] / errors_K[1], 2.0, 0.3);
  EXPECT_NEAR(errors_K[1] / errors_K[2], 2.0, 0.3);
}

TEST(LawTerms, steady_state_stays_where_it_is) {
  const Network network = make_network_with_laws();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  const BoundaryValues values = values_at_flow(network, 0.03);
  const Eigen::VectorXd steady_K = steady_temperatures_K(shared, values);
  RightHandSide rhs(shared);
  Eigen::VectorXd x(shared->nodes()), rate(shared->nodes());
  shared->to_internal(steady_K, x);
  rhs.follow(values, x.data());
  rhs.evaluate(x.data(), rate.data());
  EXPECT_LT(rate.norm() / shared->internal_per_kelvin(), 1e-9);
}

/// Adjoint sensitivities of the steady state with laws, against steady states of nudged factors.
TEST(LawTerms, steady_sensitivities_include_the_feedback) {
  const Network network = make_network_with_laws();
  const Boundaries& boundaries = network.boundaries;
  const auto shared = std::make_shared<const NetworkOperator>(network);
  const Eigen::VectorXd& row = network.deformations[0].row_m_per_K;
  CorrectionFactors factors = rom::no_correction(boundaries);
  BoundaryValues values = rom::make_boundary_values(boundaries);
  const auto output_m = [&] {
    rom::evaluate_boundaries(boundaries, boundaries.operating, factors, values);
    return row.dot(steady_temperatures_K(shared, values));
  };
  output_m();
  const SteadySensitivities found = steady_sensitivities(shared, values, steady_temperatures_K(shared, values), row);
  const auto nudged = [&](double& factor) {
    factor = std::exp(1e-4);
    const double above_m = output_m();
    factor = std::exp(-1e-4);
    const double below_m = output_m();
    factor = 1.0;
    return (above_m - below_m) / 2e-4;
  };
  const double scale = found.heat.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < found.heat.size(); ++i) {
    EXPECT_NEAR(found.heat[i], nudged(factors.heat[i]), 1e-5 * scale)
        << boundaries.sources[static_cast<std::size_t>(i)].name;
  }
  for (const Eigen::Index j : {0, 1, 7, 11}) {  // beside the segments, whose factor is on the film and not on G/A
    if (boundaries.conductances[static_cast<std::size_t>(j)].name.starts_with("groove")) continue;
    EXPECT_NEAR(found.conductance[j], nudged(factors.conductance[j]), 1e-5 * scale) << j;
  }
}

TEST(LawTerms, a_cycle_takes_nothing_from_the_heap) {
  const Network network = make_network_with_laws();
  const auto shared = std::make_shared<const NetworkOperator>(network);
  CvodeStepper stepper(shared);
  NetworkOutputs outputs = make_network_outputs(network);
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  const CorrectionFactors factors = rom::no_correction(network.boundaries);
  OperatingState state = network.boundaries.operating;
  const auto cycle = [&](int k) {
    state.speed_rpm = k % 20 < 10 ? 6000.0 : 3000.0 + 10.0 * k;
    state.flow_kg_per_s[0] = k % 30 < 15 ? 0.03 : -0.01;
    if (k > 40) state.current_A = 12.0;
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    EXPECT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    shared->laws().at_temperatures(stepper.temperatures_K(), values);
    evaluate_outputs(network, stepper.temperatures_K(), outputs);
  };
  cycle(0);
  const long before = heap_calls();
  for (int k = 1; k < 80; ++k) cycle(k);
  EXPECT_EQ(heap_calls() - before, 0);
}

TEST(LawTerms, a_law_without_a_value_stops_the_period_and_leaves_the_state) {
  Network network = make_copper_node();
  std::get<CopperLaw>(network.boundaries.sources[0].physics->law.parameters).copper.resistance_20_ohm = 1e300;
  const auto shared = std::make_shared<const NetworkOperator>(network);
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  OperatingState state = network.boundaries.operating;
  state.current_A = 1e200;
  rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
  CvodeStepper stepper(shared);
  stepper.set_temperatures(Eigen::VectorXd::Constant(1, 305.0));
  EXPECT_EQ(stepper.advance(1.0, values), StepStatus::not_finite);
  EXPECT_EQ(stepper.temperatures_K()[0], 305.0);
}

}  // namespace law_terms_test
}  // namespace spindle_twin::rom::tests
