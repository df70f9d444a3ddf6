#include "correction/identify/turning_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::correction::test {
namespace turning_parts_test {

using Names = std::vector<std::string>;

/// Rotor - bearing - sleeve with a nut on the rotor; the friction heat is in the bearing.
rom::Network with_nut() {
  rom::Network network = spindle_twin::tests::small_network();
  network.nodes[2].part = "nut";
  network.nodes[2].r_m = 0.032;
  network.parts.push_back({"nut", Eigen::VectorXd::Unit(5, 2), Eigen::MatrixXd::Identity(1, 5)});
  network.boundaries.conductances[1].part_a = 0;
  network.boundaries.conductances[1].part_b = 3;
  return network;
}

TEST(TurningParts, rotor_and_balls_turn_and_the_sleeve_does_not) {
  EXPECT_EQ(turning_parts(spindle_twin::tests::small_network()), (Names{"rotor", "bearing"}));
}

TEST(TurningParts, a_bearing_of_the_first_node_turns_as_any_other) {
  rom::Network network = spindle_twin::tests::small_network();
  network.source_distribution.setZero();
  network.source_distribution.row(0).setConstant(0.6);  // most friction is in the rotor's node
  network.source_distribution.bottomRows(1).setConstant(0.4);
  EXPECT_EQ(turning_parts(network), (Names{"rotor"}));
}

TEST(TurningParts, what_is_joined_to_the_shaft_turns_with_it) {
  EXPECT_EQ(turning_parts(with_nut()), (Names{"rotor", "bearing", "nut"}));
}

TEST(TurningParts, parts_of_a_hand_written_network_are_joined_where_heat_is_conducted_between_them) {
  rom::Network network = with_nut();
  network.hand_written = true;
  network.boundaries.conductances[1].part_a = network.boundaries.conductances[1].part_b;  // no contact
  network.conduction_W_per_K.setZero();
  EXPECT_EQ(turning_parts(network), (Names{"rotor", "bearing"}));
  Eigen::Index rotor = 0;
  while (network.nodes[static_cast<std::size_t>(rotor)].part != "rotor") ++rotor;
  network.conduction_W_per_K(2, rotor) = network.conduction_W_per_K(rotor, 2) = -1.0;
  EXPECT_EQ(turning_parts(network), (Names{"rotor", "bearing", "nut"}));
}

TEST(TurningParts, where_all_is_joined_to_the_outermost_part_only_the_balls_are_sure) {
  rom::Network network = with_nut();
  network.boundaries.conductances[0].part_a = 3;
  network.boundaries.conductances[0].part_b = 2;
  EXPECT_EQ(turning_parts(network), (Names{"bearing"}));
}

/// Rotor - nut - ring - pin, one joined to the next, told of in both orders and from either side.
TEST(TurningParts, a_whole_chain_turns_in_whatever_order_its_joints_are_told) {
  for (const bool backwards : {false, true}) {
    for (const bool swapped : {false, true}) {
      rom::Network network = spindle_twin::tests::small_network();
      for (const auto& [name, r_m] : {std::pair{"nut", 0.032}, {"ring", 0.033}, {"pin", 0.034}}) {
        network.nodes.push_back({name, name, r_m, 0.0});
        network.parts.push_back({name, Eigen::VectorXd::Unit(8, 5), Eigen::MatrixXd::Identity(1, 8)});
      }
      network.source_distribution.conservativeResizeLike(Eigen::MatrixXd::Zero(8, 2));
      std::vector<std::pair<int, int>> joints{{0, 3}, {3, 4}, {4, 5}, {-1, 5}, {0, -1}, {1, 2}};
      if (backwards) std::reverse(joints.begin(), joints.end());
      rom::Conductance contact = network.boundaries.conductances[0];
      network.boundaries.conductances.clear();
      for (const auto& [a, b] : joints) {
        contact.part_a = swapped ? b : a;
        contact.part_b = swapped ? a : b;
        network.boundaries.conductances.push_back(contact);
      }
      EXPECT_EQ(turning_parts(network), (Names{"rotor", "bearing", "nut", "ring", "pin"}));
    }
  }
}

TEST(TurningParts, a_film_joins_nothing_and_nodes_of_no_part_count_for_nothing) {
  rom::Network network = with_nut();
  network.boundaries.conductances[1].kind = rom::ConductanceKind::air_film;
  network.nodes[3].part = network.nodes[4].part = "";
  network.nodes[3].r_m = 0.001;
  network.nodes[4].r_m = 1.0;
  EXPECT_EQ(turning_parts(network), (Names{"rotor", "bearing"})) << "the nut is the outermost";
}

TEST(TurningParts, a_network_without_parts_has_none) {
  rom::Network network = spindle_twin::tests::small_network();
  network.parts.clear();
  EXPECT_TRUE(turning_parts(network).empty());
}

}  // namespace turning_parts_test
}  // namespace spindle_twin::correction::test
