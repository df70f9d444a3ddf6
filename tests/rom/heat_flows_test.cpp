#include "rom/integrate/heat_flows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/sensitivity.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom {
namespace heat_flows_test {

using tests::operating_values;

/// The first film becomes a coolant circuit's only segment, so that the liquid warms up along it.
Network with_circuit(Network network) {
  Boundaries& boundaries = network.boundaries;
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    if (boundaries.conductances[j].environment < 0) continue;
    boundaries.circuits.push_back({"water", boundaries.conductances[j].environment, 4180.0, {static_cast<int>(j)}});
    boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.01);
    break;
  }
  return network;
}

void expect_closed(const Network& network) {
  const auto coordinates = std::make_shared<const NetworkOperator>(network);
  const BoundaryValues values = operating_values(network);
  const std::vector<Body> bodies = network_bodies(network);
  const HeatFlows flows = heat_flows(network, bodies, values, steady_temperatures_K(coordinates, values));
  const double heat_in_W = values.heat_W.sum();
  ASSERT_GT(heat_in_W, 1.0);
  EXPECT_LT(flows.stored_W.cwiseAbs().maxCoeff(), 1e-9 * heat_in_W) << "a body's balance";
  EXPECT_NEAR(flows.source_W.sum(), heat_in_W, 1e-12 * heat_in_W);
  EXPECT_NEAR(flows.conduction_W.sum(), 0.0, 1e-12 * heat_in_W);
  double heat_out_W = 0.0;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const double sum_W = flows.exchange_W.col(static_cast<Eigen::Index>(j)).sum();
    if (network.boundaries.conductances[j].environment >= 0) {
      heat_out_W += sum_W;
    } else {
      EXPECT_NEAR(sum_W, 0.0, 1e-12 * heat_in_W) << "what one body loses the other gains";
    }
  }
  EXPECT_NEAR(heat_out_W, heat_in_W, 1e-9 * heat_in_W);
}

TEST(HeatFlows, balances_of_all_bodies_close_in_the_steady_state) {
  const Network network = tests::make_synthetic_network({}, 5);
  expect_closed(network);
  expect_closed(with_circuit(network));
}

TEST(HeatFlows, a_circuit_of_a_single_segment_takes_what_its_film_gives_however_warm_the_wall) {
  const Network network = with_circuit(tests::make_synthetic_network({}, 6));
  const NetworkOperator coordinates(network);
  const BoundaryValues values = operating_values(network);
  const auto n = static_cast<Eigen::Index>(network.nodes.size());
  const Eigen::VectorXd temperatures_K = Eigen::VectorXd::LinSpaced(n, 295.0, 330.0);
  const HeatFlows flows = heat_flows(network, network_bodies(network), values, temperatures_K);
  const double taken_W = flows.exchange_W.col(network.boundaries.circuits.front().segments.front()).sum();
  ASSERT_GT(std::abs(taken_W), 1.0);
  EXPECT_NEAR(coolant_outlets(coordinates, values, temperatures_K).heat_W[0], taken_W, 1e-9 * std::abs(taken_W));
}

TEST(HeatFlows, what_is_stored_is_the_change_of_heat_content) {
  const Network network = tests::make_synthetic_network({}, 6);
  const BoundaryValues values = operating_values(network);
  const auto n = static_cast<Eigen::Index>(network.nodes.size());
  const Eigen::VectorXd temperatures_K = Eigen::VectorXd::LinSpaced(n, 295.0, 310.0);
  const HeatFlows flows = heat_flows(network, network_bodies(network), values, temperatures_K);
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  Eigen::VectorXd heat_W = network.source_distribution * values.heat_W;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd term = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * network.factors_m[j] *
                                 network.factors_m[j].transpose();
    conduction += term;
    const int environment = network.boundaries.conductances[j].environment;
    if (environment >= 0) heat_W += term.rowwise().sum() * values.environment_K[environment];
  }
  const double expected_W = (heat_W - conduction * temperatures_K).sum();
  EXPECT_NEAR(flows.stored_W.sum(), expected_W, 1e-7 * heat_W.cwiseAbs().sum());
}

TEST(FlowPaths, of_a_contact_between_two_bodies_act_in_the_middle_of_both_faces) {
  const Network network = tests::make_synthetic_network({}, 6);
  int contacts = 0;
  for (const FlowPath& path : flow_paths(network, network_bodies(network))) {
    if (path.to < 0) continue;
    ++contacts;
    const Eigen::VectorXd shares =
        network.factors_m[static_cast<std::size_t>(path.conductance)].rowwise().squaredNorm();
    double r_m = 0.0, z_m = 0.0;
    for (std::size_t i = 0; i < network.nodes.size(); ++i) {
      r_m += shares[static_cast<Eigen::Index>(i)] * network.nodes[i].r_m / shares.sum();
      z_m += shares[static_cast<Eigen::Index>(i)] * network.nodes[i].z_m / shares.sum();
    }
    EXPECT_TRUE(path.has_place);
    EXPECT_NEAR(path.r_m, r_m, 1e-12) << "conductance " << path.conductance;
    EXPECT_NEAR(path.z_m, z_m, 1e-12) << "conductance " << path.conductance;
  }
  EXPECT_GE(contacts, 2);
}

TEST(Sensitivity, adjoint_equals_finite_differences) {
  for (const bool circuit : {false, true}) {
    const Network plain = tests::make_synthetic_network({}, 9);
    const Network network = circuit ? with_circuit(plain) : plain;
    const auto coordinates = std::make_shared<const NetworkOperator>(network);
    const BoundaryValues values = operating_values(network);
    const Eigen::VectorXd& row = network.deformations[0].row_m_per_K;
    const Eigen::VectorXd temperatures_K = steady_temperatures_K(coordinates, values);
    const SteadySensitivities found = steady_sensitivities(coordinates, values, temperatures_K, row);
    const double largest_m = std::max(found.conductance.cwiseAbs().maxCoeff(), found.heat.cwiseAbs().maxCoeff());
    ASSERT_GT(largest_m, 0.0);
    constexpr double step = 1e-4;
    const auto difference = [&](auto change) {
      BoundaryValues up = values, down = values;
      change(up, 1.0 + step);
      change(down, 1.0 - step);
      return row.dot(steady_temperatures_K(coordinates, up) - steady_temperatures_K(coordinates, down)) / (2.0 * step);
    };
    for (Eigen::Index j = 0; j < found.conductance.size(); ++j) {
      const double expected_m =
          difference([&](BoundaryValues& given, double factor) { given.conductance_W_per_m2K[j] *= factor; });
      EXPECT_NEAR(found.conductance[j], expected_m, 1e-6 * largest_m) << "conductance " << j << " circuit " << circuit;
    }
    for (Eigen::Index i = 0; i < found.heat.size(); ++i) {
      const double expected_m = difference([&](BoundaryValues& given, double factor) { given.heat_W[i] *= factor; });
      EXPECT_NEAR(found.heat[i], expected_m, 1e-6 * largest_m) << "heat " << i;
    }
  }
}

TEST(Sensitivity, temperatures_that_are_steady_to_a_microkelvin_are_steady_enough) {
  const Network network = tests::make_synthetic_network({}, 9);
  const auto coordinates = std::make_shared<const NetworkOperator>(network);
  const BoundaryValues values = operating_values(network);
  const Eigen::VectorXd& row = network.deformations[0].row_m_per_K;
  const Eigen::VectorXd steady_K = steady_temperatures_K(coordinates, values);
  const Eigen::VectorXd near_K = steady_K.array() + 1e-6;
  const SteadySensitivities at_steady = steady_sensitivities(coordinates, values, steady_K, row);
  const SteadySensitivities near = steady_sensitivities(coordinates, values, near_K, row);
  const double largest_m = at_steady.conductance.cwiseAbs().maxCoeff();
  EXPECT_LT((near.conductance - at_steady.conductance).cwiseAbs().maxCoeff(), 1e-5 * largest_m);
}

TEST(NetworkOperator, matrices_that_do_not_fit_together_are_refused) {
  const Network whole = tests::make_synthetic_network({}, 9);
  const Eigen::Index n = whole.capacity_J_per_K.rows();
  const std::vector<std::function<void(Network&)>> changes = {
      [](Network& network) { network.capacity_J_per_K.resize(0, 0); },
      [&](Network& network) { network.capacity_J_per_K.conservativeResize(n, n + 1); },
      [&](Network& network) { network.conduction_W_per_K.conservativeResize(n, n - 1); },
      [&](Network& network) { network.conduction_W_per_K.conservativeResize(n - 1, n); },
      [&](Network& network) { network.source_distribution.conservativeResize(n + 1, Eigen::NoChange); },
      [](Network& network) { network.factors_m.pop_back(); }};
  EXPECT_NO_THROW(NetworkOperator{whole});
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Network network = whole;
    changes[i](network);
    EXPECT_THROW(NetworkOperator{network}, std::invalid_argument) << "change " << i;
  }
}

}  // namespace heat_flows_test
}  // namespace spindle_twin::rom
