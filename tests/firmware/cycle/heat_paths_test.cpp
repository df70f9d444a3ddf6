#include "firmware/cycle/heat_paths.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::firmware {
namespace cycle_heat_paths_test {

/// Heat by the name of its contact or film; each of the small network has one path.
std::map<std::string, double> by_name(const rom::Network& network, const Snapshot& snapshot) {
  const ToldFlows told = told_flows(network);
  EXPECT_EQ(snapshot.flows, told.paths.size());
  EXPECT_EQ(snapshot.bodies, told.bodies.size());
  std::map<std::string, double> heat_W;
  for (std::size_t p = 0; p < told.paths.size(); ++p) {
    const auto j = static_cast<std::size_t>(told.paths[p].conductance);
    heat_W[network.boundaries.conductances[j].name] = snapshot.flow_W[p];
  }
  return heat_W;
}

/// Sixty plates in a row: of the contact between the last body that is told and the next one only one end is told.
TEST(HeatPaths, of_more_bodies_than_there_is_room_for_are_those_between_bodies_that_are_told) {
  const ToldFlows told = told_flows(rom::tests::make_synthetic_network({60, 1, 1, true}, 1));
  ASSERT_EQ(told.bodies.size(), slots::bodies);
  const auto room = static_cast<Eigen::Index>(slots::bodies);
  EXPECT_GE(told.paths.size(), slots::bodies - 1);
  for (const rom::FlowPath& path : told.paths) {
    EXPECT_LT(path.from, room);
    EXPECT_LT(path.to, room);
  }
}

TEST(HeatPaths, before_the_first_prediction_there_are_none) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = with_sensors();
  plan.start_temperature_K.reset();
  Cycle cycle(network, plan, runtime);
  EXPECT_EQ(cycle.step({}, {}, at_s(0), 0).flows, 0U);
}

TEST(HeatPaths, in_the_steady_state_all_heat_goes_from_rotor_and_bearing_through_the_sleeve_into_coolant_and_air) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  for (int n = 0; n < 20000; ++n) cycle.step({}, {}, at_s(n), 0);
  const Snapshot& last = cycle.step({}, {}, at_s(20000), 0);
  std::map<std::string, double> heat_W = by_name(network, last);
  EXPECT_NEAR(heat_W["rotor_bearing"], 40.0, 1e-3);
  EXPECT_NEAR(heat_W["bearing_sleeve"], 100.0, 1e-3);
  EXPECT_NEAR(heat_W["coolant"] + heat_W["air"], 100.0, 1e-3);
  double made_W = 0.0;
  for (std::size_t a = 0; a < last.bodies; ++a) made_W += last.made_W[a];
  EXPECT_NEAR(made_W, 100.0, 1e-9);
}

TEST(HeatPaths, on_the_way_there_what_does_not_go_outside_is_the_heat_that_the_nodes_take_up) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  const auto content_J = [&](const Snapshot& now) {
    const std::array<double, 5> nodes_K = {now.part_maximum_K[0], now.part_maximum_K[1], now.predicted_K[0],
                                           now.predicted_K[1], now.predicted_K[2]};
    double sum_J = 0.0;
    for (std::size_t i = 0; i < nodes_K.size(); ++i) {
      const auto node = static_cast<Eigen::Index>(i);
      sum_J += network.capacity_J_per_K(node, node) * (nodes_K[i] - start_K);
    }
    return sum_J;
  };
  const auto stored_W = [&](const Snapshot& now) {
    std::map<std::string, double> heat_W = by_name(network, now);
    return 100.0 - heat_W["coolant"] - heat_W["air"];
  };
  const Snapshot first = cycle.step({}, {}, at_s(0), 0);
  double sum_J = 0.0, before_W = stored_W(first);
  Snapshot last = first;
  for (int n = 1; n < 300; ++n) {
    last = cycle.step({}, {}, at_s(n), 0);
    const double now_W = stored_W(last);
    sum_J += 0.5 * (before_W + now_W);  // of a second
    before_W = now_W;
  }
  const double taken_up_J = content_J(last) - content_J(first);
  ASSERT_GT(taken_up_J, 1000.0);
  EXPECT_NEAR(sum_J, taken_up_J, 1e-3 * taken_up_J);
}

TEST(HeatPaths, publishing_calls_no_heap_after_the_first_time) {
  const rom::Network network = tests::small_network();
  const Machine machine(network, 1.0);
  HeatPaths paths(network, nullptr);
  Snapshot snapshot;
  paths.publish(machine.model, snapshot);
  const long before = rom::tests::heap_calls();
  paths.publish(machine.model, snapshot);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace cycle_heat_paths_test
}  // namespace spindle_twin::firmware
