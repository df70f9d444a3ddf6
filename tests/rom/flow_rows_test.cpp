#include "rom/integrate/flow_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom {
namespace flow_rows_test {

using tests::operating_values;

/// All that a network's flows are told by.
struct Told {
  explicit Told(const Network& network)
      : bodies(network_bodies(network)),
        paths(flow_paths(network, bodies)),
        rows(network, bodies, paths),
        heat_W(rows.paths()),
        made_W(rows.bodies()) {}

  /// What is made, less what goes, and what comes.
  Eigen::VectorXd stored_W() const {
    Eigen::VectorXd stored_W = made_W;
    for (std::size_t p = 0; p < paths.size(); ++p) {
      stored_W[paths[p].from] -= heat_W[static_cast<Eigen::Index>(p)];
      if (paths[p].to >= 0) stored_W[paths[p].to] += heat_W[static_cast<Eigen::Index>(p)];
    }
    return stored_W;
  }
  double outside_W() const {
    double sum_W = 0.0;
    for (std::size_t p = 0; p < paths.size(); ++p) {
      if (paths[p].to < 0) sum_W += heat_W[static_cast<Eigen::Index>(p)];
    }
    return sum_W;
  }

  std::vector<Body> bodies;
  std::vector<FlowPath> paths;
  FlowRows rows;
  Eigen::VectorXd heat_W, made_W;
};

class Rows : public testing::TestWithParam<bool> {
 protected:
  Network network_ = GetParam() ? tests::make_network_with_circuit({}, 7) : tests::make_synthetic_network({}, 7);
  BoundaryValues values_ = operating_values(network_);
  Eigen::Index nodes_ = network_.capacity_J_per_K.rows();
  Eigen::VectorXd some_K_ = Eigen::VectorXd::LinSpaced(nodes_, 295.0, 330.0);
};

TEST_P(Rows, say_what_heat_flows_says_of_the_same_state) {
  Told told(network_);
  values_.node_heat_W = Eigen::VectorXd::LinSpaced(nodes_, -1.0, 3.0);
  told.rows.evaluate(values_, some_K_, told.heat_W, told.made_W);
  const HeatFlows flows = heat_flows(network_, told.bodies, values_, some_K_);
  const double most_W = flows.exchange_W.cwiseAbs().maxCoeff();
  ASSERT_GT(most_W, 1.0);
  for (std::size_t p = 0; p < told.paths.size(); ++p) {
    EXPECT_NEAR(told.heat_W[static_cast<Eigen::Index>(p)],
                flows.exchange_W(told.paths[p].from, told.paths[p].conductance), 1e-12 * most_W);
  }
  EXPECT_LT((told.stored_W() - flows.stored_W).cwiseAbs().maxCoeff(), 1e-10 * most_W) << "the paths are all there is";
}

TEST_P(Rows, what_all_bodies_store_is_what_is_made_less_what_goes_outside) {
  Told told(network_);
  told.rows.evaluate(values_, some_K_, told.heat_W, told.made_W);
  EXPECT_NEAR(told.stored_W().sum(), values_.heat_W.sum() - told.outside_W(), 1e-9 * std::abs(told.outside_W()));
}

TEST_P(Rows, in_the_steady_state_heat_in_is_heat_out_for_each_body_and_for_all) {
  Told told(network_);
  const auto shared = std::make_shared<const NetworkOperator>(network_);
  told.rows.evaluate(values_, steady_temperatures_K(shared, values_), told.heat_W, told.made_W);
  const double heat_in_W = values_.heat_W.sum();
  ASSERT_GT(heat_in_W, 1.0);
  EXPECT_LT(told.stored_W().cwiseAbs().maxCoeff(), 1e-9 * heat_in_W);
  EXPECT_NEAR(told.outside_W(), heat_in_W, 1e-9 * heat_in_W);
}

TEST_P(Rows, at_one_temperature_nothing_flows_between_bodies) {
  Told told(network_);
  values_.heat_W.setZero();
  const double everywhere_K = 311.0;
  values_.environment_K.setConstant(everywhere_K);
  told.rows.evaluate(values_, Eigen::VectorXd::Constant(nodes_, everywhere_K), told.heat_W, told.made_W);
  EXPECT_LT(told.heat_W.cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(told.made_W.cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(Rows, are_evaluated_without_the_heap) {
  Told told(network_);
  const long before = tests::heap_calls();
  told.rows.evaluate(values_, some_K_, told.heat_W, told.made_W);
  EXPECT_EQ(tests::heap_calls() - before, 0);
}

INSTANTIATE_TEST_SUITE_P(Networks, Rows, testing::Bool(),
                         [](const auto& circuit) { return circuit.param ? "with_a_circuit" : "without"; });

}  // namespace flow_rows_test
}  // namespace spindle_twin::rom
