#include "correction/estimator/thermal_groups.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/support/small_network.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::correction::test {
namespace estimator_thermal_groups_test {

rom::Network plates_and_air() { return rom::tests::make_synthetic_network({6, 2, 2, true}, 3); }

double whole_J_per_K(const rom::Network& network) { return network.capacity_J_per_K.sum(); }

TEST(ThermalGroups, every_node_is_in_one_and_there_are_no_more_than_wanted) {
  const rom::Network network = plates_and_air();
  for (const std::size_t most : {std::size_t{1}, std::size_t{3}, std::size_t{6}, std::size_t{8}}) {
    const std::vector<ThermalGroup> groups = thermal_groups(network, most);
    EXPECT_EQ(groups.size(), std::min<std::size_t>(most, 7));  // six plates and the air
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(network.capacity_J_per_K.rows());
    double capacity_J_per_K = 0.0;
    for (const ThermalGroup& group : groups) {
      sum += group.indicator;
      capacity_J_per_K += group.capacity_J_per_K;
      EXPECT_TRUE((group.indicator.array() == 0.0 || group.indicator.array() == 1.0).all());
      EXPECT_FALSE(group.name.empty());
    }
    EXPECT_EQ(sum, Eigen::VectorXd::Ones(sum.size()));
    EXPECT_NEAR(capacity_J_per_K, whole_J_per_K(network), 1e-9 * capacity_J_per_K);
  }
}

TEST(ThermalGroups, of_a_network_with_parts_are_parts_and_of_a_hand_written_one_nodes) {
  rom::Network network = spindle_twin::tests::small_network();
  EXPECT_EQ(thermal_groups(network, 8).size(), 3u);  // rotor, bearing, sleeve of three nodes
  EXPECT_EQ(thermal_groups(network, 8)[2].indicator, (Eigen::VectorXd(5) << 0, 0, 1, 1, 1).finished());
  network.hand_written = true;
  EXPECT_EQ(thermal_groups(network, 8).size(), 5u);
}

TEST(ThermalGroups, those_that_exchange_fastest_become_one_first_under_the_name_of_the_larger) {
  // inner - middle 90 W/K of 400 and 500 J/K, middle - outer 80 W/K of 500 and 600 J/K, bearing - inner 28 W/K of 300
  // and 400 J/K, rotor - bearing 7.5 W/K of 1500 and 300 J/K: rates 0.405, 0.293, 0.163, 0.030 per second.
  rom::Network network = spindle_twin::tests::small_network();
  network.hand_written = true;
  const std::vector<ThermalGroup> four = thermal_groups(network, 4), three = thermal_groups(network, 3),
                                  two = thermal_groups(network, 2);
  EXPECT_EQ(four[2].indicator, (Eigen::VectorXd(5) << 0, 0, 1, 1, 0).finished());
  EXPECT_EQ(four[2].name, "middle");
  EXPECT_DOUBLE_EQ(four[2].capacity_J_per_K, 900.0);
  // Both together are slower with what is left: 80 (1/900 + 1/600) = 0.222 against 28 (1/300 + 1/900) = 0.124.
  EXPECT_EQ(three[2].indicator, (Eigen::VectorXd(5) << 0, 0, 1, 1, 1).finished());
  EXPECT_EQ(three[2].name, "outer");
  EXPECT_EQ(two[1].indicator, (Eigen::VectorXd(5) << 0, 1, 1, 1, 1).finished());
  EXPECT_EQ(two[0].name, "rotor");
}

}  // namespace estimator_thermal_groups_test
}  // namespace spindle_twin::correction::test
