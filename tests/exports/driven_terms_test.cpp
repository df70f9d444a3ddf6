#include "host_tools/network_files/driven_terms.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::host_tools::tests {
namespace driven_terms_test {

using Index = Eigen::Index;

/// The reference speed, half of it, a standstill, and full speed again, with as many flows.
ScheduleCourse changing_course(const rom::Network& network) {
  rom::Schedule schedule = rom::constant_schedule(network.boundaries, 4000.0);
  const rom::ScheduleRow first = schedule.rows.front();
  schedule.rows.clear();
  for (const double share : {1.0, 0.5, 0.0, 1.5, 1.0}) {
    schedule.rows.push_back(first);
    schedule.rows.back().time_s = 1000.0 * static_cast<double>(schedule.rows.size() - 1);
    schedule.rows.back().state.speed_rpm *= share;
    schedule.rows.back().state.flow_kg_per_s *= 0.5 + share;
  }
  return course_of(network.boundaries, schedule);
}

/// What leaves the nodes through contacts and films, in W per K of every node and of every environment.
Eigen::MatrixXd flows_W_per_K(const rom::Network& network, const Eigen::VectorXd& conductance_W_per_m2K) {
  const Index nodes = network.capacity_J_per_K.rows();
  Eigen::MatrixXd flows = Eigen::MatrixXd::Zero(nodes, nodes + 2);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd matrix =
        conductance_W_per_m2K[static_cast<Index>(j)] * network.factors_m[j] * network.factors_m[j].transpose();
    flows.leftCols(nodes) += matrix;
    const int environment = network.boundaries.conductances[j].environment;
    if (environment >= 0) flows.col(nodes + environment) -= matrix.rowwise().sum();
  }
  return flows;
}

/// The difference at every row of the schedule, as a share of the largest entry.
void expect_the_terms_add_up(const rom::Network& network) {
  ASSERT_EQ(network.boundaries.environments.size(), 2u);
  const ScheduleCourse course = changing_course(network);
  const DrivenTerms driven = driven_terms(network, course);
  ASSERT_FALSE(driven.terms.empty());
  for (std::size_t row = 0; row < course.values.size(); ++row) {
    const Eigen::MatrixXd wanted = flows_W_per_K(network, course.values[row].conductance_W_per_m2K);
    Eigen::MatrixXd given = flows_W_per_K(network, driven.held_W_per_m2K);
    for (const DrivenTerm& term : driven.terms) {
      given.leftCols(term.matrix.cols()) += term.course[row] * term.matrix;
      given.rightCols(2) -= term.course[row] * term.from_environment;
    }
    EXPECT_LT((given - wanted).cwiseAbs().maxCoeff(), 1e-9 * wanted.cwiseAbs().maxCoeff()) << "row " << row;
  }
}

TEST(DrivenTerms, held_part_and_terms_are_the_conductances_of_every_row) {
  expect_the_terms_add_up(rom::tests::make_synthetic_network({}, 11));
  expect_the_terms_add_up(rom::tests::make_network_with_circuit({}, 12));
}

TEST(DrivenTerms, conductances_of_one_course_become_one_term) {
  // Every contact and film, wide as the network itself, follows the speed by the same law.
  rom::Network network = rom::tests::make_synthetic_network({}, 13);
  const Index nodes = network.capacity_J_per_K.rows();
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    network.factors_m[j] = Eigen::MatrixXd::Random(nodes, nodes);
    network.boundaries.conductances[j].law = {0.5, {{0.5, 0.7}}, 0.0};
  }
  const DrivenTerms driven = driven_terms(network, changing_course(network));
  ASSERT_EQ(driven.terms.size(), 1u);
  expect_the_terms_add_up(network);
}

TEST(DrivenTerms, nothing_follows_a_schedule_that_holds) {
  const rom::Network network = rom::tests::make_network_with_circuit({}, 14);
  const ScheduleCourse course = course_of(network.boundaries, rom::constant_schedule(network.boundaries, 3600.0));
  const DrivenTerms driven = driven_terms(network, course);
  EXPECT_TRUE(driven.terms.empty());
  EXPECT_EQ(driven.held_W_per_m2K, course.values.front().conductance_W_per_m2K);
}

}  // namespace driven_terms_test
}  // namespace spindle_twin::host_tools::tests
