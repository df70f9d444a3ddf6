#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/integrate/flow_rows.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "tests/rom/by_hand_texts.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/texts.hpp"

/// Which bodies heat goes between where more than two take part, and where on the section.
namespace spindle_twin::rom::tests {
namespace flow_paths_test {

/// Shaft and housing around a volume of air, both cooled by one film; the shaft has two nodes.
const std::string around_air = in_a_room("air", R"([[node]]
name = "hall"
capacity_J_per_K = 7.0
at = [500.0, 500.0]
[[node]]
name = "nose"
part = "shaft"
capacity_J_per_K = 100.0
at = [10.0, 20.0]
[[node]]
name = "tail"
part = "shaft"
capacity_J_per_K = 100.0
at = [10.0, 80.0]
[[node]]
name = "wall"
part = "housing"
capacity_J_per_K = 300.0
at = [90.0, 50.0]
[[conduction]]
between = ["nose", "tail"]
conductance_W_per_K = 2.0
[[gap_film]]
name = "around"
faces = [{ between = ["nose", "hall"], area_mm2 = 2000.0 }, { between = ["tail", "hall"], area_mm2 = 1000.0 },
  { between = ["wall", "hall"], area_mm2 = 1500.0 }]
coefficient_W_per_m2K = 25.0
[[film]]
name = "to_room"
surrounding = "room"
faces = [{ node = "wall", area_mm2 = 50000.0 }, { node = "tail", area_mm2 = 700.0 }]
coefficient_W_per_m2K = 20.0
[[heat]]
name = "heater"
heat_W = 30.0
node = "nose"
)");

std::vector<std::string> names(const std::vector<Body>& bodies) {
  std::vector<std::string> found;
  for (const Body& body : bodies) found.push_back(body.name);
  return found;
}

TEST(NetworkBodies, are_the_parts_that_have_nodes_and_then_the_nodes_that_have_none) {
  Network network = parse_by_hand(around_air, "net.toml");
  const std::vector<Body> bodies = network_bodies(network);
  EXPECT_EQ(names(bodies), (std::vector<std::string>{"shaft", "housing", "hall"}));
  EXPECT_EQ(bodies[0].nodes, (std::vector<Eigen::Index>{1, 2}));
  EXPECT_EQ(bodies[1].nodes, std::vector<Eigen::Index>{3});
  EXPECT_EQ(bodies[2].nodes, std::vector<Eigen::Index>{0});
  network.parts.insert(network.parts.begin(), PartOutput{"empty", network.parts[0].mean_row, {}});
  EXPECT_EQ(names(network_bodies(network)), names(bodies)) << "a part without a node is none";
  network.parts.pop_back();
  EXPECT_EQ(names(network_bodies(network)), (std::vector<std::string>{"shaft", "hall", "housing"}))
      << "a node whose part is not listed stands for itself, in the order of the nodes";
}

TEST(FlowPaths, of_an_air_volume_lead_from_each_wall_to_the_air) {
  const Network network = parse_by_hand(around_air, "net.toml");
  const std::vector<Body> bodies = network_bodies(network);
  const std::vector<FlowPath> paths = flow_paths(network, bodies);
  ASSERT_EQ(paths.size(), 4U);
  constexpr Eigen::Index shaft = 0, housing = 1, air = 2;
  for (const std::size_t p : {0U, 1U}) {
    EXPECT_EQ(paths[p].conductance, 0);
    EXPECT_EQ(paths[p].to, air) << "it has all the area of the others";
  }
  EXPECT_EQ(paths[0].from, shaft);
  EXPECT_EQ(paths[1].from, housing);
  EXPECT_EQ(paths[2].from, shaft);
  EXPECT_EQ(paths[3].from, housing);
  for (const std::size_t p : {2U, 3U}) {
    EXPECT_EQ(paths[p].conductance, 1);
    EXPECT_EQ(paths[p].to, -1) << "the room";
  }
  // The place of the wall alone, by its areas; that of the air says nothing.
  EXPECT_TRUE(paths[0].has_place);
  EXPECT_NEAR(paths[0].r_m, 0.010, 1e-15);
  EXPECT_NEAR(paths[0].z_m, (2.0 * 0.020 + 1.0 * 0.080) / 3.0, 1e-15);
  EXPECT_NEAR(paths[1].r_m, 0.090, 1e-15);
  EXPECT_NEAR(paths[2].z_m, 0.080, 1e-15) << "the film touches the tail alone";
}

TEST(FlowPaths, the_heats_of_paths_are_area_times_coefficient_times_difference) {
  const Network network = parse_by_hand(around_air, "net.toml");
  BoundaryValues values = operating_values(network);
  values.node_heat_W = Eigen::Vector4d(0.5, 1.0, 2.0, 4.0);
  const Eigen::Vector4d temperatures_K(300.0, 330.0, 320.0, 310.0);
  const HeatFlows flows = heat_flows(network, network_bodies(network), values, temperatures_K);
  const double shaft_to_air_W = 25.0 * (2000e-6 * 30.0 + 1000e-6 * 20.0), housing_to_air_W = 25.0 * 1500e-6 * 10.0;
  EXPECT_NEAR(flows.exchange_W(0, 0), shaft_to_air_W, 1e-12);
  EXPECT_NEAR(flows.exchange_W(1, 0), housing_to_air_W, 1e-12);
  EXPECT_NEAR(flows.exchange_W(2, 0), -shaft_to_air_W - housing_to_air_W, 1e-12);
  const double shaft_to_room_W = 20.0 * 700e-6 * (320.0 - 293.15);
  const double housing_to_room_W = 20.0 * 50000e-6 * (310.0 - 293.15);
  EXPECT_NEAR(flows.exchange_W(0, 1), shaft_to_room_W, 1e-12);
  EXPECT_NEAR(flows.exchange_W(1, 1), housing_to_room_W, 1e-12);
  EXPECT_EQ(flows.exchange_W(2, 1), 0.0);
  EXPECT_LT(flows.conduction_W.cwiseAbs().maxCoeff(), 1e-12) << "within the shaft";
  EXPECT_EQ(flows.source_W(0, 0), 30.0);
  EXPECT_EQ(flows.node_W, Eigen::Vector3d(3.0, 4.0, 0.5));
  EXPECT_NEAR(flows.stored_W[0], 30.0 + 3.0 - shaft_to_air_W - shaft_to_room_W, 1e-11);
  EXPECT_NEAR(flows.stored_W[1], 4.0 - housing_to_air_W - housing_to_room_W, 1e-11);
  EXPECT_NEAR(flows.stored_W[2], 0.5 + shaft_to_air_W + housing_to_air_W, 1e-11);
}

TEST(FlowPaths, of_a_contact_lead_from_the_first_body_to_the_second) {
  const Network network = make_synthetic_network({}, 6);
  int contacts = 0;
  for (const FlowPath& path : flow_paths(network, network_bodies(network))) {
    if (network.boundaries.conductances[static_cast<std::size_t>(path.conductance)].environment >= 0) continue;
    EXPECT_LT(path.from, path.to) << "conductance " << path.conductance;
    ++contacts;
  }
  EXPECT_GE(contacts, 3);
}

TEST(FlowPaths, are_of_faces_however_small_and_of_none_that_has_no_area) {
  const std::string small = spindle_twin::tests::with(around_air, "area_mm2 = 700.0", "area_mm2 = 0.01");
  Network network = parse_by_hand(small, "net.toml");
  EXPECT_EQ(flow_paths(network, network_bodies(network)).size(), 4U) << "a five millionth of the wall's";
  network.factors_m[1].setZero();
  EXPECT_EQ(flow_paths(network, network_bodies(network)).size(), 2U);
}

TEST(FlowRows, of_one_body_are_its_film_its_heat_and_what_is_put_into_its_node) {
  const Network network = make_single_node();
  BoundaryValues values = operating_values(network);
  values.node_heat_W = Eigen::VectorXd::Constant(1, 7.0);
  const std::vector<Body> bodies = network_bodies(network);
  const Eigen::VectorXd warm_K = Eigen::VectorXd::Constant(1, 302.0);
  FlowRows rows(network, bodies, flow_paths(network, bodies));
  Eigen::VectorXd heat_W(1), made_W(1);
  ASSERT_EQ(rows.paths(), 1);
  rows.evaluate(values, warm_K, heat_W, made_W);
  EXPECT_NEAR(heat_W[0], 25.0 * 2.0, 1e-10);
  EXPECT_NEAR(made_W[0], 107.0, 1e-12);
  const HeatFlows flows = heat_flows(network, bodies, values, warm_K);
  EXPECT_EQ(flows.node_W[0], 7.0);
  EXPECT_NEAR(flows.stored_W[0], 107.0 - 50.0, 1e-10);
}

TEST(HeatFlows, between_bodies_without_a_contact_go_by_conduction) {
  Network network = parse_by_hand(around_air, "net.toml");
  network.nodes[2].part = "housing";  // the tail belongs to the housing now
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  values.environment_K.setConstant(300.0);
  const HeatFlows flows =
      heat_flows(network, network_bodies(network), values, Eigen::Vector4d(300.0, 330.0, 320.0, 310.0));
  EXPECT_NEAR(flows.conduction_W[0], 2.0 * 10.0, 1e-12);
  EXPECT_NEAR(flows.conduction_W[1], -2.0 * 10.0, 1e-12);
  EXPECT_NEAR(flows.stored_W[0], -2.0 * 10.0, 1e-12);
}

}  // namespace flow_paths_test
}  // namespace spindle_twin::rom::tests
