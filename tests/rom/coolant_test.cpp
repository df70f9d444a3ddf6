#include "rom/integrate/coolant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace coolant_test {

BoundaryValues values_in_state(const Network& network, const OperatingState& state) {
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
  return values;
}

/// Speed, contacts, inlet and flow jump at random; the flow stands still and runs backwards now and then.
class FlowCycle {
 public:
  FlowCycle(const Network& network, std::uint64_t seed)
      : network_(network),
        random_(seed),
        state_(network.boundaries.operating),
        factors_(rom::no_correction(network.boundaries)),
        values_(rom::make_boundary_values(network.boundaries)) {}

  const BoundaryValues& next() {
    if (--left_ < 0) {
      left_ = std::uniform_int_distribution<int>(20, 60)(random_);
      state_.speed_rpm = uniform(0.0, 20000.0);
      state_.environment_K[0] = uniform(290.0, 305.0);
      state_.flow_kg_per_s[0] = uniform(-0.02, 0.06);
      if (uniform(0.0, 1.0) < 0.2) state_.flow_kg_per_s[0] = 0.0;
      for (double& factor : factors_.conductance) factor = std::exp(uniform(-2.3, 2.3));
    }
    rom::evaluate_boundaries(network_.boundaries, state_, factors_, values_);
    return values_;
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  const Network& network_;
  std::mt19937_64 random_;
  int left_ = 0;
  OperatingState state_;
  CorrectionFactors factors_;
  BoundaryValues values_;
};

Boundaries chain_boundaries(int segments) {
  Boundaries boundaries;
  boundaries.reference_speed_rpm = 1000.0;
  boundaries.environments = {{"coolant", EnvironmentKind::coolant}};
  boundaries.circuits = {{"chain", 0, 4180.0, {}}};
  for (int s = 0; s < segments; ++s) {
    Conductance film;
    film.name = "segment " + std::to_string(s);
    film.nominal_W_per_m2K = 400.0 + 50.0 * s;
    film.area_m2 = 0.02 + 0.003 * s;
    film.environment = 0;
    boundaries.conductances.push_back(film);
    boundaries.circuits[0].segments.push_back(s);
  }
  boundaries.operating.environment_K = Eigen::VectorXd::Constant(1, 293.15);
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.02);
  return boundaries;
}

CoolantOutlets march(const Boundaries& boundaries, const Eigen::VectorXd& wall_K, double flow_kg_per_s) {
  OperatingState state = boundaries.operating;
  state.flow_kg_per_s[0] = flow_kg_per_s;
  BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), values);
  CoolantOutlets outlets{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
  march_coolant(coolant_segments(boundaries), values, wall_K, outlets);
  return outlets;
}

TEST(Coolant, uniform_wall_gives_the_exponential_outlet) {
  const Boundaries boundaries = chain_boundaries(5);
  double film_W_per_K = 0.0;
  for (const Conductance& film : boundaries.conductances) film_W_per_K += film.nominal_W_per_m2K * film.area_m2;
  for (const double flow_kg_per_s : {0.02, -0.02, 1e-5, 3.0}) {
    const CoolantOutlets outlets = march(boundaries, Eigen::VectorXd::Constant(5, 313.15), flow_kg_per_s);
    const double flow_W_per_K = std::abs(flow_kg_per_s) * 4180.0;
    EXPECT_NEAR(outlets.outlet_K[0], 313.15 - 20.0 * std::exp(-film_W_per_K / flow_W_per_K), 1e-10);
    EXPECT_NEAR(outlets.heat_W[0], flow_W_per_K * (outlets.outlet_K[0] - 293.15), 1e-9 * std::abs(outlets.heat_W[0]));
  }
}

TEST(Coolant, standing_coolant_takes_no_heat) {
  const CoolantOutlets outlets = march(chain_boundaries(3), Eigen::Vector3d(300.0, 310.0, 320.0), 0.0);
  EXPECT_EQ(outlets.heat_W[0], 0.0);
  EXPECT_NEAR(outlets.outlet_K[0], 320.0, 1e-10) << "the limit of ever slower flow";
}

TEST(Coolant, upstream_matrix_and_march_are_one_law) {
  const Boundaries boundaries = chain_boundaries(4);
  const Eigen::Vector4d wall_K(300.0, 318.0, 305.0, 299.0);
  for (const double flow_kg_per_s : {0.013, -0.013}) {
    OperatingState state = boundaries.operating;
    state.flow_kg_per_s[0] = flow_kg_per_s;
    BoundaryValues values = rom::make_boundary_values(boundaries);
    rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), values);
    Eigen::MatrixXd upstream = Eigen::MatrixXd::Zero(4, 4);
    coolant_upstream(coolant_segments(boundaries), values, upstream);
    const Eigen::VectorXd inlet_K = 293.15 + (upstream * (wall_K.array() - 293.15).matrix()).array();
    double heat_W = 0.0;
    for (int s = 0; s < 4; ++s) {
      const double area_m2 = boundaries.conductances[static_cast<std::size_t>(s)].area_m2;
      heat_W += values.conductance_W_per_m2K[s] * area_m2 * (wall_K[s] - inlet_K[s]);
    }
    EXPECT_NEAR(heat_W, march(boundaries, wall_K, flow_kg_per_s).heat_W[0], 1e-10);
  }
}

/// Two segments, half of the flow's W/K each, walls 10 and 20 K above the inlet, at any flow down to none.
TEST(Coolant, a_flow_of_less_than_a_watt_per_kelvin_is_a_flow_and_a_standing_one_is_the_end_of_a_forward_one) {
  CoolantSegments two;
  two.first = {0, 2};
  two.conductance = {0, 1};
  two.inlet = {0, 0};
  two.area_m2 = Eigen::Vector2d::Ones();
  BoundaryValues values;
  values.environment_K = Eigen::VectorXd::Constant(1, 300.0);
  const Eigen::VectorXd wall_K = Eigen::Vector2d(310.0, 320.0), rise_K = Eigen::Vector2d(10.0, 20.0);
  CoolantOutlets outlets{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
  Eigen::MatrixXd upstream(2, 2);
  Eigen::VectorXd weights(2);
  const auto flow = [&](double flow_W_per_K) {
    values.coolant_W_per_K = Eigen::VectorXd::Constant(1, flow_W_per_K);
    values.conductance_W_per_m2K = Eigen::VectorXd::Constant(2, 0.5 * std::abs(flow_W_per_K));
    march_coolant(two, values, wall_K, outlets);
    coolant_upstream(two, values, upstream);
    coolant_slope(two, values, rise_K, 0, 0, weights);
  };
  for (const double flow_W_per_K : {1e-3, 0.5, 1.0, 2.0, 1e3}) {
    flow(flow_W_per_K);
    EXPECT_NEAR(outlets.outlet_K[0], 312.5, 1e-12) << flow_W_per_K;
    EXPECT_NEAR(outlets.heat_W[0], 12.5 * flow_W_per_K, 1e-12 * flow_W_per_K);
    EXPECT_EQ(upstream, (Eigen::Matrix2d() << 0.0, 0.0, 0.5, 0.0).finished());
    EXPECT_LT((weights - Eigen::Vector2d(0.0, 5.0)).norm(), 1e-12) << flow_W_per_K;
    flow(-flow_W_per_K);
    EXPECT_NEAR(outlets.outlet_K[0], 310.0, 1e-12) << -flow_W_per_K;
    EXPECT_EQ(upstream, (Eigen::Matrix2d() << 0.0, 0.5, 0.0, 0.0).finished());
    EXPECT_LT((weights - Eigen::Vector2d(10.0, 0.0)).norm(), 1e-12) << -flow_W_per_K;
  }
  flow(0.0);
  EXPECT_EQ(outlets.outlet_K[0], 320.0) << "at the temperature of the last wall";
  EXPECT_EQ(outlets.heat_W[0], 0.0);
  EXPECT_EQ(upstream, (Eigen::Matrix2d() << 0.0, 0.0, 1.0, 0.0).finished());
  EXPECT_EQ(weights, Eigen::Vector2d::Zero());
}

TEST(Coolant, network_carries_the_heat_that_the_liquid_takes_away) {
  const Network network = make_network_with_circuit({4, 3, 3, true}, 5);
  for (const double flow_kg_per_s : {0.03, -0.03, 0.001}) {
    OperatingState state = network.boundaries.operating;
    state.flow_kg_per_s[0] = flow_kg_per_s;
    const BoundaryValues values = values_in_state(network, state);
    const auto shared = std::make_shared<const NetworkOperator>(network);
    ExactStepper stepper(shared);
    for (int k = 0; k < 4; ++k) ASSERT_EQ(stepper.advance(1e6, values), StepStatus::ok);
    const Eigen::VectorXd& temperatures_K = stepper.temperatures_K();
    // What leaves through the plain films, and through the circuit.
    double films_W = 0.0;
    for (std::size_t j = 0; j + 4 < network.factors_m.size(); ++j) {
      const int environment = network.boundaries.conductances[j].environment;
      if (environment < 0) continue;
      const Eigen::VectorXd above_K = temperatures_K.array() - values.environment_K[environment];
      films_W += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
                 (network.factors_m[j] * (network.factors_m[j].transpose() * above_K)).sum();
    }
    const CoolantSegments& segments = shared->segments();
    Eigen::VectorXd wall_K(segments.count());
    for (Eigen::Index s = 0; s < segments.count(); ++s) {
      const Eigen::MatrixXd& factor =
          network.factors_m[static_cast<std::size_t>(segments.conductance[static_cast<std::size_t>(s)])];
      wall_K[s] = (factor * (factor.transpose() * temperatures_K)).sum() / segments.area_m2[s];
    }
    CoolantOutlets outlets{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
    march_coolant(segments, values, wall_K, outlets);
    EXPECT_NEAR(films_W + outlets.heat_W[0], values.heat_W.sum(), 1e-7 * values.heat_W.sum());
    EXPECT_NEAR(std::abs(values.coolant_W_per_K[0]) * (outlets.outlet_K[0] - values.environment_K[0]),
                outlets.heat_W[0], 1e-9 * values.heat_W.sum());
  }
}

TEST(Coolant, cvode_and_exact_agree_while_the_flow_stops_and_turns) {
  const std::uint64_t seed = 41;
  const Network network = make_network_with_circuit({4, 3, 3, true}, seed);
  FlowCycle cycle(network, seed);
  const auto shared = std::make_shared<const NetworkOperator>(network);
  CvodeStepper cvode(shared);
  ExactStepper exact(shared);
  double largest_K = 0.0;
  for (int second = 0; second < 1200; ++second) {
    const BoundaryValues& values = cycle.next();
    ASSERT_EQ(cvode.advance(1.0, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(1.0, values), StepStatus::ok);
    largest_K = std::max(largest_K, (cvode.temperatures_K() - exact.temperatures_K()).lpNorm<Eigen::Infinity>());
  }
  RecordProperty("largest_mK", std::to_string(1e3 * largest_K));
  EXPECT_LT(largest_K, 1e-3);
  EXPECT_GT((exact.temperatures_K().array() - 300.15).abs().maxCoeff(), 1.0);
}

TEST(Coolant, circuit_at_great_flow_is_a_plain_film) {
  Network network = make_network_with_circuit({3, 3, 3, true}, 8);
  network.boundaries.operating.flow_kg_per_s[0] = 1e6;
  Network plain = network;
  plain.boundaries.circuits.clear();
  plain.boundaries.operating.flow_kg_per_s.resize(0);
  ExactStepper with(std::make_shared<const NetworkOperator>(network));
  ExactStepper without(std::make_shared<const NetworkOperator>(plain));
  ASSERT_EQ(with.advance(500.0, values_in_state(network, network.boundaries.operating)), StepStatus::ok);
  ASSERT_EQ(without.advance(500.0, values_in_state(plain, plain.boundaries.operating)), StepStatus::ok);
  EXPECT_LT((with.temperatures_K() - without.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-6);
}

TEST(Coolant, no_heap_call_in_the_cycle_after_warm_up) {
  const Network network = make_network_with_circuit({8, 5, 5, true}, 101);
  const auto stepper = make_runtime_stepper(network);
  FlowCycle cycle(network, 101);
  stepper->advance(1.0, cycle.next());
  StepStatus status = StepStatus::ok;
  const long before = heap_calls();
  for (int second = 0; second < 300 && status == StepStatus::ok; ++second) {
    status = stepper->advance(1.0, cycle.next());
  }
  EXPECT_EQ(heap_calls() - before, 0);
  EXPECT_EQ(status, StepStatus::ok);
  EXPECT_EQ(stepper->fallbacks(), 0);
}

TEST(Coolant, file_keeps_circuits_and_their_absence) {
  const Network network = make_network_with_circuit({3, 2, 2, true}, 3);
  const Network read = decode_network(encode_network(network), "test.rom");
  ASSERT_EQ(read.boundaries.circuits.size(), 1u);
  const CoolantCircuit &is = read.boundaries.circuits[0], &should_be = network.boundaries.circuits[0];
  EXPECT_EQ(is.name, should_be.name);
  EXPECT_EQ(is.environment, should_be.environment);
  EXPECT_EQ(is.heat_capacity_J_per_kgK, should_be.heat_capacity_J_per_kgK);
  EXPECT_EQ(is.segments, should_be.segments);
  EXPECT_EQ(read.boundaries.operating.flow_kg_per_s, network.boundaries.operating.flow_kg_per_s);
  EXPECT_EQ(encode_network(read), encode_network(network));
  const Network plain = make_synthetic_network({3, 2, 2, true}, 3);
  EXPECT_TRUE(decode_network(encode_network(plain), "test.rom").boundaries.circuits.empty());
  // Field 1, schema_version, right behind the header of 52 bytes.
  EXPECT_EQ(encode_network(network)[53], 6);
}

TEST(Coolant, file_with_a_broken_circuit_is_refused) {
  const Network good = make_network_with_circuit({3, 2, 2, true}, 3);
  const auto refused = [&](auto spoil) {
    Network bad = good;
    spoil(bad.boundaries.circuits[0]);
    EXPECT_THROW(check_network(bad, "test.rom"), InputError);
  };
  refused([](CoolantCircuit& circuit) { circuit.segments.clear(); });
  refused([](CoolantCircuit& circuit) { circuit.segments.push_back(circuit.segments.front()); });
  refused([](CoolantCircuit& circuit) { circuit.segments[0] = 1000; });
  refused([](CoolantCircuit& circuit) { circuit.segments[0] = 0; });
  refused([](CoolantCircuit& circuit) { circuit.environment = 1; });
  refused([](CoolantCircuit& circuit) { circuit.heat_capacity_J_per_kgK = 0.0; });
  EXPECT_NO_THROW(check_network(good, "test.rom"));
}

}  // namespace coolant_test
}  // namespace spindle_twin::rom::tests
