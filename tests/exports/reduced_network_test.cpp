#include "host_tools/network_files/reduced_network.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::host_tools::tests {
namespace reduced_network_test {

using Index = Eigen::Index;

constexpr double tolerance_K = 1e-3;

/// 97 nodes with contacts, films that follow the speed, and a circuit.
rom::Network full_network() { return rom::tests::make_network_with_circuit({4, 6, 4}, 21); }

rom::Schedule changing_schedule(const rom::Boundaries& boundaries) {
  rom::Schedule schedule = rom::constant_schedule(boundaries, 1800.0);
  schedule.rows.insert(schedule.rows.begin() + 1, 2, schedule.rows.front());
  schedule.rows[1].time_s = 600.0;
  schedule.rows[1].state.speed_rpm *= 2.0;
  schedule.rows[1].state.flow_kg_per_s *= 0.5;
  schedule.rows[2].time_s = 1200.0;
  schedule.rows[2].state.speed_rpm = 0.0;
  schedule.rows[3].state.environment_K.array() += 3.0;
  return schedule;
}

struct Compared {
  double nodes_K = 0.0, key_points_K = 0.0, deformations_m = 0.0;
};

/// Largest differences of two networks by the exact solution, every 7 s of the schedule.
Compared compare(const rom::Network& full, const rom::Network& reduced, const rom::Schedule& schedule) {
  Compared worst;
  const rom::CorrectionFactors factors = rom::no_correction(full.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(full.boundaries);
  rom::OperatingState state = full.boundaries.operating;
  rom::ExactStepper exact(std::make_shared<rom::NetworkOperator>(full));
  rom::ExactStepper other(std::make_shared<rom::NetworkOperator>(reduced));
  rom::state_at(schedule, 0.0, state);
  const double start_K = state.environment_K[1];
  exact.set_temperatures(Eigen::VectorXd::Constant(full.capacity_J_per_K.rows(), start_K));
  other.set_temperatures(Eigen::VectorXd::Constant(reduced.capacity_J_per_K.rows(), start_K));
  for (double time_s = 0.0; time_s < schedule.end_s; time_s += 7.5) {
    rom::state_at(schedule, time_s + 3.75, state);
    rom::evaluate_boundaries(full.boundaries, state, factors, values);
    EXPECT_EQ(exact.advance(7.5, values), rom::StepStatus::ok);
    EXPECT_EQ(other.advance(7.5, values), rom::StepStatus::ok);
    const Eigen::VectorXd full_K = exact.temperatures_K(), reduced_K = other.temperatures_K();
    for (std::size_t r = 0; r < reduced.nodes.size(); ++r) {
      for (std::size_t n = 0; n < full.nodes.size(); ++n) {
        if (full.nodes[n].name != reduced.nodes[r].name) continue;
        const double error_K = reduced_K[static_cast<Index>(r)] - full_K[static_cast<Index>(n)];
        worst.nodes_K = std::max(worst.nodes_K, std::abs(error_K));
      }
    }
    for (std::size_t i = 0; i < full.key_points.size(); ++i) {
      const double error_K = reduced.key_points[i].row.dot(reduced_K) - full.key_points[i].row.dot(full_K);
      worst.key_points_K = std::max(worst.key_points_K, std::abs(error_K));
    }
    const Eigen::VectorXd full_rise = full_K.array() - full.boundaries.reference_temperature_K;
    const Eigen::VectorXd reduced_rise = reduced_K.array() - full.boundaries.reference_temperature_K;
    for (std::size_t i = 0; i < full.deformations.size(); ++i) {
      const double error_m =
          reduced.deformations[i].row_m_per_K.dot(reduced_rise) - full.deformations[i].row_m_per_K.dot(full_rise);
      worst.deformations_m = std::max(worst.deformations_m, std::abs(error_m));
    }
  }
  return worst;
}

TEST(ReducedNetwork, follows_the_full_one_also_between_the_instants_that_it_was_made_from) {
  const rom::Network full = full_network();
  const rom::Schedule schedule = changing_schedule(full.boundaries);
  const ReducedNetwork reduced = reduced_network(full, course_of(full.boundaries, schedule), tolerance_K);
  std::printf("%zu of %zu nodes, largest error %.1e K\n", reduced.network.nodes.size(), full.nodes.size(),
              reduced.largest_error_K);
  ASSERT_LT(reduced.network.nodes.size(), full.nodes.size() / 2);
  EXPECT_GT(reduced.largest_error_K, 0.0);
  EXPECT_LE(reduced.largest_error_K, tolerance_K);
  EXPECT_LE(reduced.largest_node_error_K, 4.0 * tolerance_K);
  const Compared worst = compare(full, reduced.network, schedule);
  EXPECT_LT(worst.nodes_K, 8.0 * tolerance_K);
  EXPECT_LT(worst.key_points_K, 2.0 * tolerance_K);
  double stiffest_m_per_K = 0.0;
  for (const rom::DeformationOutput& output : full.deformations) {
    stiffest_m_per_K = std::max(stiffest_m_per_K, output.row_m_per_K.lpNorm<1>());
  }
  EXPECT_LT(worst.deformations_m, 2.0 * tolerance_K * stiffest_m_per_K);
}

TEST(ReducedNetwork, keeps_capacity_heat_and_films_of_the_whole) {
  const rom::Network full = full_network();
  const ReducedNetwork made =
      reduced_network(full, course_of(full.boundaries, changing_schedule(full.boundaries)), tolerance_K);
  const rom::Network& reduced = made.network;
  ASSERT_LT(reduced.nodes.size(), full.nodes.size());
  EXPECT_NEAR(reduced.capacity_J_per_K.sum(), full.capacity_J_per_K.sum(), 1e-9 * full.capacity_J_per_K.sum());
  for (Index s = 0; s < full.source_distribution.cols(); ++s) {
    EXPECT_NEAR(reduced.source_distribution.col(s).sum(), full.source_distribution.col(s).sum(), 1e-9);
  }
  EXPECT_LT(reduced.conduction_W_per_K.rowwise().sum().norm(), 1e-9 * reduced.conduction_W_per_K.norm());
  for (std::size_t j = 0; j < full.factors_m.size(); ++j) {
    const double area_m2 = full.factors_m[j].colwise().sum().squaredNorm();
    EXPECT_NEAR(reduced.factors_m[j].colwise().sum().squaredNorm(), area_m2, 1e-9 * full.factors_m[j].squaredNorm());
  }
  for (const rom::KeyPoint& point : reduced.key_points) EXPECT_NEAR(point.row.sum(), 1.0, 1e-9);
}

TEST(ReducedNetwork, one_node_is_enough_where_nothing_happens) {
  rom::Network full = full_network();
  full.source_distribution.setZero();
  rom::Schedule schedule = rom::constant_schedule(full.boundaries, 3600.0);
  for (rom::ScheduleRow& row : schedule.rows) row.state.environment_K.setConstant(300.0);
  const ReducedNetwork reduced = reduced_network(full, course_of(full.boundaries, schedule), tolerance_K);
  EXPECT_EQ(reduced.network.nodes.size(), 1u);
  EXPECT_LE(reduced.largest_error_K, tolerance_K);
}

TEST(ReducedNetwork, a_tolerance_that_takes_all_nodes_gives_the_network_as_it_is) {
  const rom::Network full = full_network();
  const ReducedNetwork reduced =
      reduced_network(full, course_of(full.boundaries, changing_schedule(full.boundaries)), 1e-13);
  EXPECT_EQ(reduced.network.nodes.size(), full.nodes.size());
  EXPECT_EQ(reduced.largest_error_K, 0.0);
}

}  // namespace reduced_network_test
}  // namespace spindle_twin::host_tools::tests
