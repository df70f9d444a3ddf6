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

/// Three equal nodes in a row.
rom::Network three_in_a_row(double first_W_per_K, double second_W_per_K) {
  rom::Network network;
  network.nodes = {{"first", "", 0.0, 0.0}, {"second", "", 0.0, 0.0}, {"third", "", 0.0, 0.0}};
  network.capacity_J_per_K = 100.0 * Eigen::MatrixXd::Identity(3, 3);
  Eigen::Matrix3d conduction;
  conduction << first_W_per_K, -first_W_per_K, 0.0,                     //
      -first_W_per_K, first_W_per_K + second_W_per_K, -second_W_per_K,  //
      0.0, -second_W_per_K, second_W_per_K;
  network.conduction_W_per_K = conduction;
  return network;
}

TEST(ThermalGroups, of_equally_fast_and_equally_large_ones_the_first_two_become_one_under_the_first_name) {
  const std::vector<ThermalGroup> two = thermal_groups(three_in_a_row(1.0, 1.0), 2);
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(two[0].indicator, Eigen::Vector3d(1.0, 1.0, 0.0));
  EXPECT_EQ(two[0].name, "first");
  EXPECT_EQ(two[1].name, "third");
}

/// The pair that exchanges half as much is nearly as fast where one of its two is small, and no faster, wherever it is.
TEST(ThermalGroups, of_two_pairs_the_capacities_of_both_bodies_count_alike) {
  rom::Network network = three_in_a_row(1.0, 0.5);  // 0.020 and 0.019 per second
  network.capacity_J_per_K(2, 2) = 1.0 / 0.028;
  EXPECT_EQ(thermal_groups(network, 2)[0].indicator, Eigen::Vector3d(1.0, 1.0, 0.0));
  network = three_in_a_row(0.5, 1.0);
  network.capacity_J_per_K(0, 0) = 1.0 / 0.028;
  EXPECT_EQ(thermal_groups(network, 2)[0].indicator, Eigen::Vector3d(1.0, 0.0, 0.0));
}

/// What two of them lose to one environment they do not exchange.
TEST(ThermalGroups, a_film_over_two_bodies_is_no_exchange_between_them) {
  rom::Network network = three_in_a_row(1.0, 0.9);
  rom::Conductance film;
  film.environment = 0;
  film.nominal_W_per_m2K = 0.5;
  network.boundaries.conductances = {film};
  network.factors_m = {Eigen::Vector3d(1.0, 1.0, 0.0)};
  EXPECT_EQ(thermal_groups(network, 2)[0].indicator, Eigen::Vector3d(1.0, 1.0, 0.0));
  network.boundaries.conductances[0].environment = -1;
  network.factors_m = {Eigen::Vector3d(0.0, 1.0, -1.0)};
  EXPECT_EQ(thermal_groups(network, 2)[0].indicator, Eigen::Vector3d(1.0, 0.0, 0.0)) << "a joint is one";
}

}  // namespace estimator_thermal_groups_test
}  // namespace spindle_twin::correction::test
