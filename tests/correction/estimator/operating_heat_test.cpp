#include "correction/estimator/operating_heat.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "correction/estimator/parameters.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "tests/rom/by_hand_texts.hpp"

namespace spindle_twin::correction::test {
namespace estimator_operating_heat_test {

/// 100 W in a, through 10 W/K into b, from there 1 W/K into the room and `to_c_W_per_K` to c, which has 1 W/K of its
/// own; d hangs at c and has no way out.
rom::Network chain(double to_c_W_per_K) {
  std::string text;
  for (const std::string node : {"a", "b", "c", "d"}) {
    text += "[[node]]\nname = \"" + node + "\"\ncapacity_J_per_K = 100.0\n[[key_point]]\nname = \"" + node +
            "\"\nnode = \"" + node + "\"\n";
  }
  text +=
      "[[conduction]]\nbetween = [\"a\", \"b\"]\nconductance_W_per_K = 10.0\n[[conduction]]\nbetween = [\"b\", "
      "\"c\"]\nconductance_W_per_K = " +
      std::to_string(to_c_W_per_K) +
      "\n[[conduction]]\nbetween = [\"c\", \"d\"]\nconductance_W_per_K = 5.0\n"
      "[[heat]]\nname = \"loss\"\nnode = \"a\"\nheat_W = 100.0\n";
  for (const std::string node : {"b", "c"}) {
    text += "[[film]]\nname = \"air_" + node + "\"\nsurrounding = \"room\"\nnode = \"" + node +
            "\"\narea_mm2 = 100000.0\ncoefficient_W_per_m2K = 10.0\n";
  }
  return rom::parse_by_hand(rom::tests::in_a_room("chain", text), "chain.toml");
}

TEST(HeatThroughGroups, is_all_heat_in_a_chain_and_its_share_behind_a_branch) {
  const rom::Network network = chain(1.0);
  const std::vector<ThermalGroup> groups = thermal_groups(network, 8);
  ASSERT_EQ(groups.size(), 4u);
  const std::vector<double> through_W = heat_through_groups_W(network, groups);
  EXPECT_NEAR(through_W[0], 100.0, 1e-9);
  EXPECT_NEAR(through_W[1], 100.0, 1e-9);
  EXPECT_NEAR(through_W[2], 100.0 / 3.0, 1e-9) << "1 W/K beside 1 and 1 W/K in series";
  EXPECT_NEAR(through_W[3], 0.0, 1e-9) << "no way out";
}

TEST(HeatThroughGroups, is_all_that_crosses_the_border_of_a_group) {
  const rom::Network network = chain(1.0);
  const std::vector<ThermalGroup> groups = thermal_groups(network, 2);
  ASSERT_EQ(groups.size(), 2u);
  double both_W = 0.0;
  for (const double through_W : heat_through_groups_W(network, groups)) both_W += through_W;
  EXPECT_NEAR(both_W, 100.0 + 100.0 / 3.0, 1e-9) << "a and b exchange fastest, and so do c and d";
}

TEST(HeatThroughGroups, without_a_way_out_counts_all_heats_everywhere) {
  rom::Network network = chain(1.0);
  for (Eigen::MatrixXd& film_m : network.factors_m) film_m.setZero();
  network.conduction_W_per_K.setZero();
  for (const double through_W : heat_through_groups_W(network, thermal_groups(network, 8))) {
    EXPECT_EQ(through_W, 100.0);
  }
}

/// Where the share of all heats is switched off, a node that leads nowhere keeps its unexplained heat.
TEST(HeatThroughGroups, of_nothing_leaves_a_group_its_unexplained_heat) {
  const rom::Network network = chain(1.0);
  EstimatorPriors priors;
  priors.disturbance = 0.0;
  const ParameterModel model(network, priors);
  ASSERT_EQ(model.group_count(), 4);
  for (Eigen::Index g = 0; g < 4; ++g) {
    ASSERT_EQ(model.disturbance(g), model.disturbance(0) + g) << "one after the other";
    const double deviation_W = model.list()[static_cast<std::size_t>(model.disturbance(g))].deviation;
    EXPECT_NEAR(deviation_W,
                0.1 * std::max(1.0, heat_through_groups_W(network, model.groups())[static_cast<std::size_t>(g)]), 1e-9);
  }
}

}  // namespace estimator_operating_heat_test
}  // namespace spindle_twin::correction::test
