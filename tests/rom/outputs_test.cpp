#include <gtest/gtest.h>

#include <cmath>

#include "rom/integrate/outputs.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace outputs_test {

TEST(Outputs, a_uniform_rise_shows_everywhere_and_moves_the_nose_by_the_sum_of_its_row) {
  const Network network = make_synthetic_network({}, 1);
  NetworkOutputs outputs = make_network_outputs(network);
  evaluate_outputs(network, Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 301.15), outputs);
  EXPECT_NEAR((outputs.key_points_K.array() - 301.15).abs().maxCoeff(), 0.0, 1e-10);
  EXPECT_NEAR((outputs.part_mean_K.array() - 301.15).abs().maxCoeff(), 0.0, 1e-10);
  EXPECT_NEAR(outputs.deformations_m[0], network.deformations[0].row_m_per_K.sum(), 1e-18);
  evaluate_outputs(network, Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 300.15), outputs);
  EXPECT_NEAR(outputs.deformations_m[0], 0.0, 1e-18);
}

TEST(Outputs, contact_pressure_is_that_of_the_assembly_plus_its_row_times_the_rises) {
  Network network = make_synthetic_network({}, 1);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  network.contact_pressures = {{"fit", 2e6, Eigen::VectorXd::LinSpaced(n, -1e5, 3e5)}};
  NetworkOutputs outputs = make_network_outputs(network);
  const double row_sum_Pa_per_K = network.contact_pressures[0].row_Pa_per_K.sum();
  evaluate_outputs(network, Eigen::VectorXd::Constant(n, 303.15), outputs);
  ASSERT_EQ(outputs.contact_pressures_Pa.size(), 1);
  EXPECT_NEAR(outputs.contact_pressures_Pa[0], 2e6 + 3.0 * row_sum_Pa_per_K, 1e-9 * std::abs(row_sum_Pa_per_K));
}

TEST(Outputs, extremes_are_those_of_the_part_alone_and_nothing_is_allocated) {
  const Network network = make_synthetic_network({}, 2);
  NetworkOutputs outputs = make_network_outputs(network);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  const Eigen::VectorXd rising_K = Eigen::VectorXd::LinSpaced(n, 300.0, 300.0 + static_cast<double>(n - 1));
  const long before = heap_calls();
  evaluate_outputs(network, rising_K, outputs);
  EXPECT_EQ(heap_calls() - before, 0);
  for (Eigen::Index body = 0; body < 4; ++body) {
    const double first_K = 300.0 + 16.0 * static_cast<double>(body);
    EXPECT_NEAR(outputs.part_minimum_K[body], first_K, 1e-9);
    EXPECT_NEAR(outputs.part_maximum_K[body], first_K + 15.0, 1e-9);
    EXPECT_NEAR(outputs.part_mean_K[body], first_K + 7.5, 1e-9);
    EXPECT_NEAR(outputs.key_points_K[body], first_K + 8.3, 1e-9);
  }
}

}  // namespace outputs_test
}  // namespace spindle_twin::rom::tests
