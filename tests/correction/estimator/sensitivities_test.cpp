#include <gtest/gtest.h>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_sensitivities_test {

constexpr double sensitivities_end_s = 600.0;
constexpr double integration_K = 3e-5;  // that CVODE is exact to, over all nodes

/// Nothing that a model run from given parameters would not show: no forgetting, no unknown start.
EstimatorOptions plain_options(double period_s) {
  EstimatorOptions options;
  options.period_s = period_s;
  options.priors.environment_memory_s = 0.0;
  options.priors.start_K = 0.0;
  return options;
}

/// Node temperatures after sensitivities_end_s of a run with a speed step, nothing measured, at these parameters.
Eigen::VectorXd run(const rom::Network& network, const Eigen::VectorXd& theta, double cycle_s, double period_s,
                    Eigen::MatrixXd* sensitivities = nullptr) {
  Pair pair(network, plain_options(period_s));
  pair.cycle_s = cycle_s;
  pair.valid.setConstant(false);
  pair.estimator.reset(0.0, pair.twin.stepper.temperatures_K(), pair.operating);
  pair.estimator.set_parameters(theta);
  pair.operating.environment_K[0] += 3.0;
  while (pair.time_s < sensitivities_end_s - 1e-9) {
    pair.operating.speed_rpm = pair.time_s < 0.5 * sensitivities_end_s ? 9000.0 : 4000.0;
    pair.estimator.set_parameters(theta);
    pair.cycle();
  }
  pair.cycle();  // the sensitivities of the last period are carried on at its end
  if (sensitivities != nullptr) *sensitivities = pair.estimator.sensitivities_K();
  return pair.estimator.corrected_nodes_K();
}

/// Up to a share of each difference and what CVODE is exact to.
void expect_differences(const rom::Network& network, double share, double exact_K) {
  const EstimatorCorrection estimator(network, plain_options(10.0));
  Eigen::VectorXd theta = estimator.parameters().mean();
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    theta[i] += (i % 2 == 0 ? 0.5 : -0.5) * estimator.parameters().list()[static_cast<std::size_t>(i)].deviation;
  }
  Eigen::MatrixXd sensitivities;
  run(network, theta, 1.0, 2.0, &sensitivities);
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const double step = 2e-2 * estimator.parameters().list()[static_cast<std::size_t>(i)].deviation;
    Eigen::VectorXd high = theta, low = theta;
    high[i] += step;
    low[i] -= step;
    const Eigen::VectorXd difference = (run(network, high, 1.0, 2.0) - run(network, low, 1.0, 2.0)) / (2.0 * step);
    EXPECT_LT((sensitivities.col(i) - difference).norm(), share * difference.norm() + exact_K / step)
        << estimator.parameters().list()[static_cast<std::size_t>(i)].name;
  }
}

TEST(Sensitivities, equal_differences_of_the_integrated_network_for_every_parameter) {
  expect_differences(plates(), 0.02, integration_K);
}

/// What the liquid carries from wall to wall is taken as it was when the period began, hence the larger share. Equal
/// runs of CVODE differ by up to 5e-4 K here (measured: the effect of the ambient).
TEST(Sensitivities, of_a_coolant_circuit_equal_differences_whichever_way_it_flows_and_while_it_stands) {
  rom::Network network = rom::tests::make_network_with_circuit({3, 2, 2, true}, 7);
  network.certificate = {};
  ASSERT_GT(network.boundaries.circuits[0].segments.size(), 1u);
  for (const double flow_kg_per_s : {0.01, -0.01, 0.0}) {
    network.boundaries.operating.flow_kg_per_s[0] = flow_kg_per_s;
    expect_differences(network, 0.06, 6e-4);
  }
}

TEST(Sensitivities, of_more_nodes_than_one_block_of_the_substitution_equal_differences) {
  rom::Network network = rom::tests::make_synthetic_network({5, 5, 5, true}, 7);
  network.certificate = {};
  ASSERT_GT(network.nodes.size(), 100u);
  const EstimatorCorrection estimator(network, plain_options(10.0));
  const Eigen::VectorXd theta = estimator.parameters().mean();
  Eigen::MatrixXd sensitivities;
  run(network, theta, 1.0, 2.0, &sensitivities);
  constexpr double step = 1e-2;
  for (const int slot : {estimator.parameters().heat(0), estimator.parameters().heat(1)}) {
    Eigen::VectorXd high = theta, low = theta;
    high[slot] += step;
    low[slot] -= step;
    const Eigen::VectorXd difference = (run(network, high, 1.0, 2.0) - run(network, low, 1.0, 2.0)) / (2.0 * step);
    EXPECT_LT((sensitivities.col(slot) - difference).norm(), 0.02 * difference.norm() + integration_K / step);
  }
}

TEST(Sensitivities, converge_with_the_period) {
  const rom::Network network = plates();
  const EstimatorCorrection estimator(network, plain_options(10.0));
  const Eigen::VectorXd theta = estimator.parameters().mean();
  Eigen::MatrixXd coarse, middle, fine;
  run(network, theta, 1.0, 20.0, &coarse);
  run(network, theta, 1.0, 10.0, &middle);
  run(network, theta, 1.0, 2.0, &fine);
  const double coarse_error = (coarse - fine).norm(), middle_error = (middle - fine).norm();
  EXPECT_LT(middle_error, 0.5 * coarse_error);
  EXPECT_LT(middle_error, 0.01 * fine.norm());
}

}  // namespace estimator_sensitivities_test
}  // namespace spindle_twin::correction::test
