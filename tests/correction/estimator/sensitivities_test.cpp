#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "correction/estimator/held_period.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

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

/// A groove through a single plate: nothing flows from segment to segment, but the liquid warms up in it all the same.
TEST(Sensitivities, of_a_circuit_of_one_segment_equal_differences) {
  rom::Network network = rom::tests::make_network_with_circuit({1, 3, 2, true}, 7);
  network.certificate = {};
  ASSERT_EQ(network.boundaries.circuits[0].segments.size(), 1U);
  network.boundaries.operating.flow_kg_per_s[0] = 0.01;
  expect_differences(network, 0.06, 6e-4);
}

/// One watt, and one watt per square metre and kelvin: what a node follows, over the root of its capacity.
TEST(Sensitivities, of_a_single_node_are_driven_as_its_equation_says) {
  rom::Network network = rom::tests::make_single_node();
  network.boundaries.sources[0].nominal_W = 1.0;
  network.boundaries.conductances[0].nominal_W_per_m2K = 1.0;
  network.boundaries.operating.environment_K[0] = 303.0;
  const ParameterModel parameters(network, {});
  Sensitivities sensitivities(network, std::make_shared<const rom::NetworkOperator>(network), parameters);
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  const Eigen::VectorXd theta = parameters.neutral(), start_K = Eigen::VectorXd::Constant(1, 305.0),
                        end_K = Eigen::VectorXd::Constant(1, 321.0);
  const HeldInterval held{10.0, 6000.0, start_K, end_K, values, theta};
  const Eigen::VectorXd drive =
      std::sqrt(1000.0) * sensitivities.drive_at(held, parameters).row(0).transpose();  // in W
  EXPECT_NEAR(drive[parameters.heat(0)], 1.0, 1e-12);
  EXPECT_NEAR(drive[parameters.conductance(0)], -0.5 * (313.0 - 303.0), 1e-12) << "half a square metre";
  EXPECT_NEAR(drive[parameters.environment(0)], 0.5, 1e-12);
  EXPECT_NEAR(drive[parameters.disturbance(0)], 1.0, 1e-12);
  EXPECT_EQ(drive[parameters.start()], 0.0);
  EXPECT_EQ(drive[parameters.expansion()], 0.0);

  EstimatorPriors films;  // the film as the only parameter is driven no otherwise
  films.heat = films.environment_K = films.expansion = films.start_K = films.disturbance = 0.0;
  const ParameterModel film(network, films);
  ASSERT_EQ(film.count(), 1);
  Sensitivities alone(network, std::make_shared<const rom::NetworkOperator>(network), film);
  const Eigen::VectorXd no_factor = film.neutral();
  EXPECT_NEAR(alone.drive_at({10.0, 6000.0, start_K, end_K, values, no_factor}, film)(0, 0),
              drive[parameters.conductance(0)] / std::sqrt(1000.0), 1e-12);
}

/// An ambient that is 4 K warmer than it reads warms a body of 3 K by its film.
TEST(HeldPeriod, holds_what_environments_are_and_not_what_they_read) {
  const rom::Network network = rom::tests::make_single_node();
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
  const ParameterModel parameters(network, {});
  for (const double bias_K : {4.0, 2.0}) {
    Sensitivities sensitivities(network, coordinates, parameters);
    sensitivities.start(parameters);
    HeldPeriod period(network, coordinates);
    const Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(1, 303.0), theta = parameters.neutral();
    EXPECT_EQ(period.close(5.0, nodes_K, theta, parameters, sensitivities), 0.0) << "nothing was open";
    period.open(20.0, nodes_K, network.boundaries.operating, parameters.make_factors(network),
                Eigen::VectorXd::Constant(1, bias_K));
    EXPECT_EQ(period.opened_s(), 20.0);
    EXPECT_EQ(period.close(21.0, nodes_K, theta, parameters, sensitivities), 1.0);
    EXPECT_FALSE(period.is_open());
    // 25 W/K over 1000 J/K for a second: 0.025 of the difference, but for what the node itself gives way.
    const double expected_K = 0.025 * (bias_K - 3.0);
    EXPECT_NEAR(sensitivities.in_kelvin()(0, parameters.conductance(0)), expected_K, 0.02 * std::abs(expected_K));
  }
}

TEST(Sensitivities, of_a_hand_written_network_stay_over_no_time_too) {
  const rom::Network network = spindle_twin::tests::small_network_by_hand();
  const ParameterModel parameters(network, {});
  ASSERT_TRUE(parameters.has_capacities());
  Sensitivities sensitivities(network, std::make_shared<const rom::NetworkOperator>(network), parameters);
  sensitivities.start(parameters);
  const Eigen::MatrixXd at_start = sensitivities.in_kelvin();
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  const Eigen::VectorXd theta = parameters.mean(), warm_K = Eigen::VectorXd::Constant(at_start.rows(), 310.0);
  EXPECT_TRUE(sensitivities.advance({0.0, 3000.0, warm_K, warm_K, values, theta}, parameters));
  EXPECT_EQ(sensitivities.in_kelvin(), at_start);
}

/// Vector instructions take four at a time.
TEST(Sensitivities, have_as_many_rows_as_fill_a_multiple_of_four) {
  const rom::Network network = plates();
  for (const Eigen::Index left_out : {0, 1, 2, 3, 4}) {
    EstimatorPriors priors;
    if (left_out > 0) priors.bearing_per_K = 0.0;
    if (left_out > 1) priors.speed_exponent = 0.0;  // of two heats
    if (left_out > 2) priors.expansion = 0.0;
    if (left_out > 3) priors.environment_K = 0.0;  // two
    const ParameterModel parameters(network, priors);
    const Sensitivities sensitivities(network, std::make_shared<const rom::NetworkOperator>(network), parameters);
    EXPECT_EQ(sensitivities.transposed().rows(), 4 * ((parameters.count() + 3) / 4));
    EXPECT_EQ(sensitivities.in_kelvin().cols(), parameters.count());
  }
}

TEST(Sensitivities, over_no_time_stay_and_begin_anew_with_the_start_alone) {
  const rom::Network network = plates();
  const ParameterModel parameters(network, {});
  Sensitivities sensitivities(network, std::make_shared<const rom::NetworkOperator>(network), parameters);
  sensitivities.start(parameters);
  const Eigen::MatrixXd at_start = sensitivities.in_kelvin();
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Eigen::VectorXd expected = parameters.is_start(i)
                                         ? parameters.shapes()[static_cast<std::size_t>(i - parameters.start())].rise_K
                                         : Eigen::VectorXd::Zero(at_start.rows());
    EXPECT_LT((at_start.col(i) - expected).norm(), 1e-9) << i;
  }
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  const Eigen::VectorXd theta = parameters.mean(), warm_K = Eigen::VectorXd::Constant(at_start.rows(), 310.0);
  for (const double period_s : {0.0, -5.0}) {
    EXPECT_TRUE(sensitivities.advance({period_s, 6000.0, warm_K, warm_K, values, theta}, parameters));
    EXPECT_EQ(sensitivities.in_kelvin(), at_start);
  }
  EXPECT_TRUE(sensitivities.advance({10.0, 6000.0, warm_K, warm_K, values, theta}, parameters));
  EXPECT_GT(sensitivities.in_kelvin().col(parameters.heat(0)).norm(), 0.0);
  sensitivities.clear(parameters.heat(0));
  EXPECT_EQ(sensitivities.in_kelvin().col(parameters.heat(0)).norm(), 0.0);
  sensitivities.restart(parameters);
  EXPECT_GT(sensitivities.in_kelvin().col(parameters.heat(1)).norm(), 0.0) << "of the others nothing is forgotten";
  EXPECT_LT((sensitivities.in_kelvin().col(parameters.start()) - at_start.col(parameters.start())).norm(), 1e-9);
  const Eigen::VectorXd step = Eigen::VectorXd::LinSpaced(parameters.count(), -0.1, 0.2);
  Eigen::VectorXd nodes_K = warm_K;
  sensitivities.correct(step, nodes_K);
  EXPECT_LT((nodes_K - warm_K - sensitivities.in_kelvin() * step).norm(), 1e-9);
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
