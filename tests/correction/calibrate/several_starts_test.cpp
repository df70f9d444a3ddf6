#include "correction/calibrate/several_starts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/calibrate/unknowns.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_several_starts_test {

constexpr double hidden = 0.8;  // ln of the joint's factor

/// 1000 W at the first node; 25 W/K from each node to the surroundings; a joint of 25 e^y W/K that leads from the first
/// node to the second one and from there on, so that the second one's steady rise is the same for y and −y:
///   rise = 1000 W / (75 W/K + 25 W/K (e^y + e^−y))
rom::Network with_two_answers() {
  rom::Network network = rom::tests::make_single_node();
  network.nodes = {{"first", "first", 0.0, 0.0}, {"second", "second", 0.0, 0.0}};
  network.capacity_J_per_K = 100.0 * Eigen::MatrixXd::Identity(2, 2);
  network.conduction_W_per_K = 25.0 * Eigen::MatrixXd::Identity(2, 2);
  network.source_distribution = Eigen::Vector2d(1.0, 0.0);
  network.boundaries.sources[0].nominal_W = 1000.0;
  rom::Conductance& joint = network.boundaries.conductances[0];
  joint.name = "joint";
  joint.kind = rom::ConductanceKind::contact;
  joint.environment = -1;
  Eigen::MatrixXd factor(2, 2);
  factor << 1.0, 0.0, -1.0, 1.0;
  network.factors_m = {std::sqrt(0.5) * factor};
  network.key_points = {{"second", "second", 0.0, 0.0, Eigen::Vector2d(0.0, 1.0)}};
  network.parts.clear();
  network.deformations.clear();
  return network;
}

CalibrateOptions joint_alone(const rom::Network& network) {
  CalibrateOptions options = calibrate_options(network);
  options.priors.heat = options.priors.environment_K = options.priors.start_K = 0.0;
  options.joint_wander = 0.0;
  return options;
}

ThermalTest steady(const rom::Network& network, double joint = hidden) {
  const double rise_K = 1000.0 / (75.0 + 25.0 * (std::exp(joint) + std::exp(-joint)));
  ThermalTest test;
  test.name = "steady";
  test.start_K = network.boundaries.reference_temperature_K;
  for (int k = 0; k <= 60; ++k) {
    test.time_s.push_back(60.0 * k);
    test.operating.push_back(network.boundaries.operating);
  }
  test.measured_K = Eigen::MatrixXd::Constant(61, 1, test.start_K + rise_K);
  test.measured_K.topRows(2).setConstant(std::numeric_limits<double>::quiet_NaN());
  test.deformation_m.resize(61, 0);
  return test;
}

TEST(SeveralStarts, where_two_answers_are_about_as_good_both_are_covered) {
  const rom::Network network = with_two_answers();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    CalibrateOptions options = joint_alone(network);
    options.start_seed = seed;
    const TestPredictor predictor(network, options);
    const std::vector<ThermalTest> tests{steady(network)};
    const FitTask task{network, predictor, options, tests};
    const Eigen::VectorXd mean = TestUnknowns(network, predictor.parameters(), options, 1).mean();
    ASSERT_EQ(predictor.parameters().count(), 1);
    options.starts = 1;
    const SeveralStarts one = fit_from_several(task, mean, {});
    // The prior's mean lies nearer to the wrong one.
    EXPECT_NEAR(one.fit.z[0], -hidden, 0.05);
    EXPECT_GT(hidden - one.fit.z[0], 10.0 * std::sqrt(one.fit.covariance(0, 0)));
    options.starts = 5;
    const SeveralStarts five = fit_from_several(task, mean, {});
    ASSERT_EQ(five.starts.size(), 5u);
    EXPECT_NEAR(std::abs(five.fit.z[0]), hidden, 0.05);
    EXPECT_LT(std::abs(hidden - five.fit.z[0]), 2.02 * std::sqrt(five.fit.covariance(0, 0)));
    EXPECT_GT(2.0 * hidden, 1.9 * std::sqrt(five.fit.covariance(0, 0))) << "once, however many starts lead there";
    int evaluations = 0;
    for (const StartedFit& start : five.starts) evaluations += start.evaluations;
    EXPECT_EQ(five.fit.evaluations, evaluations);
    EXPECT_TRUE(std::any_of(five.starts.begin(), five.starts.end(), [](const auto& start) { return start.is_other; }));
    // ½ (y − mean)²/σ² of the prior is all that tells them apart.
    const double prior_mean = mean[0], deviation = options.priors.contact;
    const double expected =
        (std::pow(hidden - prior_mean, 2.0) - std::pow(hidden + prior_mean, 2.0)) / 2.0 / (deviation * deviation);
    for (const StartedFit& start : five.starts) {
      if (!start.is_other) continue;
      EXPECT_NEAR(start.cost, expected, 0.1);
    }
  }
}

/// The weaker the joint, the nearer the two answers: at last the readings no longer keep them apart.
TEST(SeveralStarts, answers_are_two_where_a_deviation_lies_between_them) {
  const rom::Network network = with_two_answers();
  int near = 0;
  for (int k = 0; k <= 20; ++k) {
    CalibrateOptions options = joint_alone(network);
    options.starts = 3;
    const TestPredictor predictor(network, options);
    const std::vector<ThermalTest> tests{steady(network, 0.06 + 0.002 * k)};
    const FitTask task{network, predictor, options, tests};
    const Eigen::VectorXd mean = TestUnknowns(network, predictor.parameters(), options, 1).mean();
    for (const StartedFit& start : fit_from_several(task, mean, {}).starts) {
      EXPECT_EQ(start.is_other, start.apart > 1.0) << start.apart;
      EXPECT_LT(start.cost, 3.0);
      near += start.apart > 1.0 && start.apart < 2.0 ? 1 : 0;
    }
  }
  EXPECT_GT(near, 0);
}

/// A sensor on the first node, the better the less one of the answers is believed: up to a cost of 3, and no further.
TEST(SeveralStarts, answers_are_about_as_good_where_one_costs_less_than_three_more) {
  rom::Network network = with_two_answers();
  network.key_points.push_back({"first", "first", 0.0, 0.0, Eigen::Vector2d(1.0, 0.0)});
  int dear = 0, cheap = 0;
  for (int k = 6; k <= 10; ++k) {
    CalibrateOptions options = joint_alone(network);
    options.starts = 5;
    options.sensor_error_K = options.sensor_error_share = 0.0;
    options.sensors[1].noise_K = 10.0 * std::pow(1.2, k);
    const TestPredictor predictor(network, options);
    std::vector<ThermalTest> tests{steady(network)};
    ThermalTest& test = tests.front();
    const double second_K = test.measured_K(60, 0) - test.start_K;
    test.measured_K.conservativeResize(61, 2);
    test.measured_K.col(1) = test.measured_K.col(0);
    test.measured_K.col(1).array() += second_K * std::exp(-hidden);  // 25 W/K outwards of the second, and the joint
    const FitTask task{network, predictor, options, tests};
    const Eigen::VectorXd mean = TestUnknowns(network, predictor.parameters(), options, 1).mean();
    for (const StartedFit& start : fit_from_several(task, mean, {}).starts) {
      EXPECT_EQ(start.is_other, start.apart > 1.0 && start.cost < 3.0) << start.apart << " " << start.cost;
      if (start.apart <= 1.0) continue;
      dear += start.cost > 3.0 && start.cost < 6.0 ? 1 : 0;
      cheap += start.cost < 3.0 ? 1 : 0;
    }
  }
  EXPECT_GT(dear, 0);
  EXPECT_GT(cheap, 0);
}

TEST(SeveralStarts, of_a_test_with_one_answer_all_lead_to_it) {
  const rom::Network network = plates();
  CalibrateOptions options = calibrate_options(network);
  options.starts = 5;
  const TestPredictor predictor(network, options);
  const std::vector<ThermalTest> tests{record(network, predictor.parameters(), drawn(predictor.parameters(), 11), {})};
  const FitTask task{network, predictor, options, tests};
  const Eigen::VectorXd mean = TestUnknowns(network, predictor.parameters(), options, 1).mean();
  const SeveralStarts found = fit_from_several(task, mean, {});
  ASSERT_EQ(found.starts.size(), 5u);
  for (const StartedFit& start : found.starts) {
    EXPECT_LT(start.apart, 0.5);
    EXPECT_FALSE(start.is_other);
  }
  EXPECT_EQ(found.fit.covariance, fit_tests(task, &mean, {}).covariance);
  EXPECT_EQ(found.fit.z, fit_from_several(task, mean, {}).fit.z);
}

}  // namespace calibrate_several_starts_test
}  // namespace spindle_twin::correction::test
