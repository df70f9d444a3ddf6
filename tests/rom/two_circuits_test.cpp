#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/coolant.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/flow_rows.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

/// Two circuits of their own inlets and flows on one spindle: the liquid of one never meets that of the other.
namespace spindle_twin::rom::tests {
namespace two_circuits_test {

/// The four segments of one circuit become two of two, the second from the second environment, backwards.
Network network_with_two_circuits() {
  Network network = make_network_with_circuit({4, 2, 2, true}, 17);
  Boundaries& boundaries = network.boundaries;
  const std::vector<int> segments = boundaries.circuits[0].segments;
  boundaries.circuits = {{"front", 0, 4180.0, {segments[0], segments[1]}},
                         {"rear", 1, 2000.0, {segments[2], segments[3]}}};
  for (const int segment : {segments[2], segments[3]}) {
    boundaries.conductances[static_cast<std::size_t>(segment)].environment = 1;
  }
  boundaries.operating.flow_kg_per_s = Eigen::Vector2d(0.02, -0.015);
  boundaries.operating.environment_K = Eigen::Vector2d(295.15, 305.15);
  return network;
}

BoundaryValues values_at(const Network& network, const Eigen::VectorXd& flow_kg_per_s) {
  OperatingState state = network.boundaries.operating;
  state.flow_kg_per_s = flow_kg_per_s;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
  return values;
}

BoundaryValues operating_values(const Network& network) {
  return values_at(network, network.boundaries.operating.flow_kg_per_s);
}

CoolantOutlets marched(const CoolantSegments& segments, const BoundaryValues& values, const Eigen::VectorXd& wall_K) {
  const auto circuits = static_cast<Eigen::Index>(segments.first.size()) - 1;
  CoolantOutlets outlets{Eigen::VectorXd::Zero(circuits), Eigen::VectorXd::Zero(circuits)};
  march_coolant(segments, values, wall_K, outlets);
  return outlets;
}

TEST(TwoCircuits, each_is_what_it_is_without_the_other) {
  const Network network = network_with_two_circuits();
  const BoundaryValues values = operating_values(network);
  const CoolantSegments both = coolant_segments(network.boundaries);
  const Eigen::Vector4d wall_K(301.0, 316.0, 298.0, 322.0);
  const CoolantOutlets together = marched(both, values, wall_K);
  Eigen::MatrixXd upstream(4, 4);
  coolant_upstream(both, values, upstream);
  for (std::size_t c = 0; c < 2; ++c) {
    Boundaries alone = network.boundaries;
    alone.circuits = {network.boundaries.circuits[c]};
    BoundaryValues alone_values = values;
    const auto circuit = static_cast<Eigen::Index>(c);
    alone_values.coolant_W_per_K = values.coolant_W_per_K.segment(circuit, 1);
    const CoolantSegments segments = coolant_segments(alone);
    const CoolantOutlets outlets = marched(segments, alone_values, wall_K.segment(2 * circuit, 2));
    EXPECT_NEAR(together.outlet_K[circuit], outlets.outlet_K[0], 1e-12 * 300.0);
    EXPECT_NEAR(together.heat_W[circuit], outlets.heat_W[0], 1e-9);
    Eigen::MatrixXd own(2, 2);
    coolant_upstream(segments, alone_values, own);
    EXPECT_EQ(upstream.block(2 * circuit, 2 * circuit, 2, 2), own);
    EXPECT_EQ(upstream.block(2 * circuit, 2 - 2 * circuit, 2, 2), Eigen::Matrix2d::Zero());
  }
}

/// Along the flow each segment enters at the mix of what came and the wall that it passed; nothing comes from behind.
TEST(TwoCircuits, what_enters_a_segment_is_the_share_that_the_walls_before_have_given) {
  const Network network = network_with_two_circuits();
  const CoolantSegments segments = coolant_segments(network.boundaries);
  for (const double flow_kg_per_s : {0.02, 0.0}) {
    const BoundaryValues values = values_at(network, Eigen::Vector2d(flow_kg_per_s, -flow_kg_per_s));
    Eigen::MatrixXd upstream(4, 4);
    coolant_upstream(segments, values, upstream);
    const auto share = [&](Eigen::Index s, Eigen::Index circuit) {
      if (flow_kg_per_s == 0.0) return 1.0;  // liquid that hardly moves leaves as warm as the wall
      const int conductance = segments.conductance[static_cast<std::size_t>(s)];
      return values.conductance_W_per_m2K[conductance] * segments.area_m2[s] /
             std::abs(values.coolant_W_per_K[circuit]);
    };
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(4, 4);
    expected(1, 0) = share(0, 0);
    if (flow_kg_per_s == 0.0) {
      expected(3, 2) = 1.0;  // no direction: as it is written
    } else {
      expected(2, 3) = share(3, 1);
    }
    EXPECT_LT((upstream - expected).cwiseAbs().maxCoeff(), 1e-14) << flow_kg_per_s;
  }
}

/// Temperatures follow from the ratio of films to flows alone, however small both are.
TEST(TwoCircuits, flows_and_films_that_shrink_together_change_no_temperature) {
  const Network network = network_with_two_circuits();
  const CoolantSegments segments = coolant_segments(network.boundaries);
  const BoundaryValues values = operating_values(network);
  BoundaryValues small = values;
  constexpr double part = 1e-5;
  small.coolant_W_per_K *= part;
  small.conductance_W_per_m2K *= part;
  const Eigen::Vector4d wall_K(301.0, 316.0, 298.0, 322.0);
  const CoolantOutlets is = marched(segments, small, wall_K), expected = marched(segments, values, wall_K);
  EXPECT_LT((is.outlet_K - expected.outlet_K).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((is.heat_W / part - expected.heat_W).cwiseAbs().maxCoeff(), 1e-6);
  Eigen::MatrixXd upstream(4, 4), small_upstream(4, 4);
  coolant_upstream(segments, values, upstream);
  coolant_upstream(segments, small, small_upstream);
  EXPECT_LT((small_upstream - upstream).cwiseAbs().maxCoeff(), 1e-12);
  Eigen::VectorXd weights(4), small_weights(4);
  for (const int changed : {0, 3}) {
    coolant_slope(segments, values, wall_K.array() - 300.0, changed < 2 ? 0 : 1, changed, weights);
    coolant_slope(segments, small, wall_K.array() - 300.0, changed < 2 ? 0 : 1, changed, small_weights);
    EXPECT_LT((small_weights - weights).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(TwoCircuits, a_segments_slope_is_the_change_of_what_all_segments_meet) {
  const Network network = network_with_two_circuits();
  const CoolantSegments segments = coolant_segments(network.boundaries);
  const Eigen::Vector4d wall_rise_K(6.0, 21.0, -7.0, 17.0);
  for (const double sign : {1.0, -1.0}) {
    const BoundaryValues values = values_at(network, sign * network.boundaries.operating.flow_kg_per_s);
    const auto met = [&](int changed, double by_W_per_m2K) {
      BoundaryValues moved = values;
      moved.conductance_W_per_m2K[segments.conductance[static_cast<std::size_t>(changed)]] += by_W_per_m2K;
      Eigen::MatrixXd upstream(4, 4);
      coolant_upstream(segments, moved, upstream);
      Eigen::VectorXd heats = upstream * wall_rise_K;
      for (Eigen::Index s = 0; s < 4; ++s) {
        heats[s] *= moved.conductance_W_per_m2K[segments.conductance[static_cast<std::size_t>(s)]];
      }
      return heats;
    };
    for (int changed = 0; changed < 4; ++changed) {
      Eigen::VectorXd weights(4);
      coolant_slope(segments, values, wall_rise_K, changed < 2 ? 0 : 1, changed, weights);
      const Eigen::VectorXd expected = (met(changed, 0.5) - met(changed, -0.5)) / 1.0;
      EXPECT_LT((weights - expected).cwiseAbs().maxCoeff(), 1e-8) << sign << " segment " << changed;
    }
  }
  const BoundaryValues still = values_at(network, Eigen::Vector2d::Zero());
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(4);
  coolant_slope(segments, still, wall_rise_K, 1, 2, weights);
  EXPECT_EQ(weights, Eigen::VectorXd::Zero(4)) << "standing liquid takes nothing along";
}

TEST(TwoCircuits, steady_heat_leaves_through_each_as_its_own_liquid_warms) {
  const Network network = network_with_two_circuits();
  check_network(network, "two circuits");
  const auto shared = share(network);
  const BoundaryValues values = operating_values(network);
  const Eigen::VectorXd steady_K = steady_temperatures_K(shared, values);
  const CoolantOutlets outlets = coolant_outlets(*shared, values, steady_K);
  const std::vector<Body> bodies = network_bodies(network);
  const HeatFlows flows = heat_flows(network, bodies, values, steady_K);
  const double heat_in_W = values.heat_W.sum();
  EXPECT_LT(flows.stored_W.cwiseAbs().maxCoeff(), 1e-8 * heat_in_W);
  for (Eigen::Index c = 0; c < 2; ++c) {
    const CoolantCircuit& circuit = network.boundaries.circuits[static_cast<std::size_t>(c)];
    double taken_W = 0.0;
    for (const int segment : circuit.segments) taken_W += flows.exchange_W.col(segment).sum();
    EXPECT_NEAR(outlets.heat_W[c], taken_W, 1e-9 * heat_in_W) << circuit.name;
    const double warmed_K = outlets.outlet_K[c] - values.environment_K[circuit.environment];
    EXPECT_NEAR(std::abs(values.coolant_W_per_K[c]) * warmed_K, taken_W, 1e-9 * heat_in_W) << circuit.name;
  }
  const std::vector<FlowPath> paths = flow_paths(network, bodies);
  FlowRows rows(network, bodies, paths);
  Eigen::VectorXd heat_W(rows.paths()), made_W(rows.bodies());
  rows.evaluate(values, steady_K, heat_W, made_W);
  for (std::size_t p = 0; p < paths.size(); ++p) {
    EXPECT_NEAR(heat_W[static_cast<Eigen::Index>(p)], flows.exchange_W(paths[p].from, paths[p].conductance),
                1e-9 * heat_in_W);
  }
}

TEST(TwoCircuits, both_steppers_agree_while_one_flow_turns_and_the_other_stops) {
  const Network network = network_with_two_circuits();
  const auto shared = share(network);
  CvodeStepper cvode(shared);
  ExactStepper exact(shared);
  for (const auto& [front_kg_per_s, rear_kg_per_s] :
       {std::pair{0.02, -0.015}, {-0.01, -0.015}, {-0.01, 0.0}, {0.0, 0.03}}) {
    const BoundaryValues values = values_at(network, Eigen::Vector2d(front_kg_per_s, rear_kg_per_s));
    for (int second = 0; second < 60; ++second) {
      ASSERT_EQ(cvode.advance(1.0, values), StepStatus::ok);
      ASSERT_EQ(exact.advance(1.0, values), StepStatus::ok);
      ASSERT_LT((cvode.temperatures_K() - exact.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-3);
    }
  }
}

TEST(TwoCircuits, the_file_keeps_which_segment_belongs_to_which) {
  const Network network = network_with_two_circuits();
  const Boundaries read = decode_network(encode_network(network), "two.rom").boundaries;
  ASSERT_EQ(read.circuits.size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(read.circuits[c].name, network.boundaries.circuits[c].name);
    EXPECT_EQ(read.circuits[c].environment, network.boundaries.circuits[c].environment);
    EXPECT_EQ(read.circuits[c].segments, network.boundaries.circuits[c].segments);
  }
  EXPECT_EQ(read.operating.flow_kg_per_s, network.boundaries.operating.flow_kg_per_s);
}

}  // namespace two_circuits_test
}  // namespace spindle_twin::rom::tests
