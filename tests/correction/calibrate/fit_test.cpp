#include "correction/calibrate/fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>

#include "correction/calibrate/residual_covariance.hpp"
#include "correction/calibrate/test_steps.hpp"
#include "tests/correction/calibrate/fitted_node.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_fit_test {

struct FitOfNode : testing::Test {
  FitOfNode() : predictor(node.network, node.options) {
    node.read(predictor, 0.15, 2e-6);
    unknowns = std::make_unique<TestUnknowns>(node.network, predictor.parameters(), node.options, 2);
  }
  FitTask task() const { return {node.network, predictor, node.options, node.tests}; }
  Eigen::MatrixXd assumed(const TestFit& fit, std::size_t test) const {
    return residual_covariance(fit.readings[test], predictor.parameters(), node.options,
                               start_spread_K(node.tests[test], node.options));
  }
  FittedNode node;
  TestPredictor predictor;
  std::unique_ptr<TestUnknowns> unknowns;
};

TEST_F(FitOfNode, is_judged_by_what_is_left_of_each_reading_against_what_was_assumed_and_what_is_open) {
  Eigen::VectorXd z = unknowns->mean();
  for (Eigen::Index i = 0; i < z.size(); ++i) z[i] += 0.1 * static_cast<double>(i % 3) * unknowns->root()(i, i);
  const Eigen::MatrixXd open = 0.25 * unknowns->root() * unknowns->root().transpose();
  const TestFit fit = judge_tests(task(), z, open);
  ASSERT_EQ(fit.readings.size(), 2U);
  ASSERT_GT(fit.readings[0].readings.size(), fit.readings[1].readings.size());
  double squares = 0.0, count = 0.0, cost = 0.0;
  for (std::size_t test = 0; test < 2; ++test) {
    const Eigen::MatrixXd weight = assumed(fit, test), rows = unknowns->rows(fit.readings[test], test);
    EXPECT_LT((fit.expected[test] - weight - rows * open * rows.transpose()).norm(), 1e-12 * fit.expected[test].norm());
    for (Eigen::Index r = 0; r < fit.left[test].size(); ++r) {
      const TestReading& reading = fit.readings[test].readings[static_cast<std::size_t>(r)];
      EXPECT_EQ(fit.left[test][r], reading.residual - unknowns->offset(z, test, reading.channel));
    }
    squares += fit.left[test].dot(weight.inverse() * fit.left[test]);
    count += static_cast<double>(fit.left[test].size());
    cost += 0.5 * fit.left[test].dot(fit.weights[test].inverse() * fit.left[test]) +
            Eigen::LLT<Eigen::MatrixXd>(fit.weights[test]).matrixLLT().diagonal().array().log().sum();
  }
  EXPECT_NEAR(fit.chi_square_per_reading, squares / count, 1e-6 * squares / count);
  EXPECT_NEAR(fit.cost, cost, 1e-6 * std::abs(cost));
  EXPECT_EQ(fit.z, z);
  EXPECT_EQ(fit.evaluations, 0) << "nothing was fitted";
  EXPECT_EQ(fit.covariance, open);
}

TEST_F(FitOfNode, of_each_channel_its_rms_its_neighbours_and_outliers_are_those_of_its_own_readings) {
  node.tests[0].measured_K.topRows(2).array() += 10.0;
  node.tests[0].measured_K.middleRows(28, 2).array() -= 10.0;
  const TestFit fit =
      judge_tests(task(), unknowns->mean(), 1e-4 * Eigen::MatrixXd::Identity(unknowns->count(), unknowns->count()));
  for (std::size_t test = 0; test < 2; ++test) {
    const Eigen::MatrixXd weight = assumed(fit, test);
    for (Eigen::Index r = 0; r < weight.rows(); ++r) {
      const double q = std::abs(fit.left[test][r]) / std::sqrt(weight(r, r));
      EXPECT_NEAR(fit.weights[test](r, r) / weight(r, r), q > 3.0 ? 1.0 + q * (q / 3.0 - 1.0) : 1.0,
                  1e-9 * (1.0 + q * q));
    }
  }
  for (const double share : {0.0, 0.5}) {
    const std::vector<ChannelFit> channels = channels_from(task(), fit, share);
    ASSERT_EQ(channels.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      const ChannelFit& found = channels[k];
      EXPECT_EQ(found.test, k / 2);
      EXPECT_EQ(found.channel, static_cast<int>(k % 2));
      EXPECT_EQ(found.name, k % 2 == 0 ? "body" : "nose");
      std::vector<double> left, expected;
      for (std::size_t r = 0; r < fit.readings[found.test].readings.size(); ++r) {
        const TestReading& reading = fit.readings[found.test].readings[r];
        if (reading.channel != found.channel || reading.time_s < share * node.tests[found.test].length_s()) continue;
        left.push_back(fit.left[found.test][static_cast<Eigen::Index>(r)]);
        expected.push_back(fit.expected[found.test].diagonal()[static_cast<Eigen::Index>(r)]);
      }
      double squares = 0.0, variances = 0.0, products = 0.0;
      std::size_t outliers = 0;
      for (std::size_t i = 0; i < left.size(); ++i) {
        squares += left[i] * left[i];
        variances += expected[i];
        if (i > 0) products += left[i] * left[i - 1];
        outliers += left[i] * left[i] > 9.0 * expected[i] ? 1 : 0;
      }
      const auto count = static_cast<double>(left.size());
      EXPECT_EQ(found.readings, left.size());
      EXPECT_NEAR(found.rms, std::sqrt(squares / count), 1e-12);
      EXPECT_NEAR(found.expected_rms, std::sqrt(variances / count), 1e-12);
      EXPECT_NEAR(found.lag_1, products / squares, 1e-12);
      EXPECT_EQ(found.outliers, outliers);
      EXPECT_GE(outliers, k == 0 ? 1U : 0U);
    }
  }
  EXPECT_EQ(fit.channels.size(), 4U);
  EXPECT_EQ(fit.channels[2].rms, channels_from(task(), fit, 0.0)[2].rms);
}

TEST_F(FitOfNode, a_reading_at_the_instant_itself_belongs_to_the_last_part_and_a_channel_without_one_is_left_out) {
  const TestFit fit =
      judge_tests(task(), unknowns->mean(), Eigen::MatrixXd::Identity(unknowns->count(), unknowns->count()));
  const double last_s = fit.readings[0].readings.back().time_s, share = last_s / node.tests[0].length_s();
  ASSERT_EQ(share * node.tests[0].length_s(), last_s);
  const std::vector<ChannelFit> last = channels_from(task(), fit, share);
  ASSERT_EQ(last.size(), 2U) << "the other test's last reading is before";
  for (const ChannelFit& channel : last) {
    EXPECT_EQ(channel.test, 0U);
    EXPECT_EQ(channel.readings, 1U);
    EXPECT_EQ(channel.rms, std::abs(fit.left[0].tail(2)[channel.channel]));
    EXPECT_EQ(channel.lag_1, 0.0) << "it has no neighbour";
  }
  EXPECT_TRUE(channels_from(task(), fit, 1.001).empty());
}

TEST_F(FitOfNode, of_a_channel_that_misses_nothing_neighbours_say_nothing) {
  TestFit fit = judge_tests(task(), unknowns->mean(), Eigen::MatrixXd::Identity(unknowns->count(), unknowns->count()));
  fit.left[1].setZero();
  const std::vector<ChannelFit> channels = channels_from(task(), fit, 0.0);
  ASSERT_EQ(channels.size(), 4U);
  for (const std::size_t k : {2U, 3U}) {
    EXPECT_EQ(channels[k].rms, 0.0);
    EXPECT_EQ(channels[k].lag_1, 0.0);
    EXPECT_EQ(channels[k].outliers, 0U);
  }
}

/// The header's W: of the start, then twice of where the pass before has ended, there wider where readings are far off.
TEST_F(FitOfNode, is_three_passes_each_with_what_is_assumed_where_the_one_before_has_ended) {
  node.tests[0].measured_K.middleRows(20, 2).array() += 5.0;
  const Eigen::VectorXd start = unknowns->mean();
  const TestFit at_start = judge_tests(task(), start, Eigen::MatrixXd::Zero(start.size(), start.size()));
  const TestFit first = fit_tests_once(task(), start, {assumed(at_start, 0), assumed(at_start, 1)});
  const TestFit second = fit_tests_once(task(), first.z, first.weights);
  const TestFit third = fit_tests_once(task(), second.z, second.weights);
  const TestFit fit = fit_tests(task(), nullptr, {});
  const Eigen::VectorXd deviation = fit.covariance.diagonal().cwiseSqrt();
  EXPECT_LT((third.z - fit.z).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT((second.z - fit.z).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((third.covariance - fit.covariance).norm(), 1e-6 * fit.covariance.norm());
}

TEST_F(FitOfNode, ends_where_readings_and_priors_pull_alike_and_its_posterior_is_that_of_a_straight_line_there) {
  int told = 0;
  const TestFit before = fit_tests(task(), nullptr, [&](int count) { EXPECT_EQ(count, ++told); });
  EXPECT_EQ(before.evaluations, told);
  const TestFit fit = fit_tests_once(task(), before.z, before.weights);
  const Eigen::MatrixXd& root = unknowns->root();
  const Eigen::VectorXd u = root.triangularView<Eigen::Lower>().solve(fit.z - unknowns->mean());
  Eigen::VectorXd pull = -u;
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(u.size(), u.size());
  double cost = 0.5 * u.squaredNorm();
  for (std::size_t test = 0; test < 2; ++test) {
    const Eigen::MatrixXd inverse = before.weights[test].inverse();
    const Eigen::MatrixXd in_u = unknowns->rows(fit.readings[test], test) * root;
    pull += in_u.transpose() * inverse * fit.left[test];
    information += in_u.transpose() * inverse * in_u;
    cost += 0.5 * fit.left[test].dot(fit.weights[test].inverse() * fit.left[test]) +
            Eigen::LLT<Eigen::MatrixXd>(fit.weights[test]).matrixLLT().diagonal().array().log().sum();
  }
  EXPECT_GT(u.norm(), 0.3) << "something was to be found";
  EXPECT_LT(std::sqrt(pull.dot(information.inverse() * pull)), 0.05) << "in deviations of the posterior";
  const Eigen::MatrixXd posterior = root * information.inverse() * root.transpose();
  const Eigen::VectorXd deviation = posterior.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      EXPECT_NEAR(fit.covariance(i, k), posterior(i, k), 1e-3 * deviation[i] * deviation[k]) << i << " " << k;
    }
  }
  EXPECT_NEAR(fit.cost, cost, 1e-6 * std::abs(cost));
}

TEST_F(FitOfNode, begun_where_it_ends_it_has_little_to_do_and_stays_there) {
  const TestFit fit = fit_tests(task(), nullptr, {});
  const TestFit again = fit_tests(task(), &fit.z, {});
  EXPECT_LT(again.evaluations, fit.evaluations);
  const Eigen::VectorXd deviation = fit.covariance.diagonal().cwiseSqrt();
  EXPECT_LT((again.z - fit.z).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 0.2);
  const TestFit once = fit_tests_once(task(), fit.z, fit.weights);
  EXPECT_LE(once.evaluations, 5) << "it begins there";
  EXPECT_LT((once.z - fit.z).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 0.1);
  const TestFit from_afar = fit_tests_once(task(), unknowns->mean(), fit.weights);
  EXPECT_NEAR(from_afar.cost, once.cost, 0.05);
}

TEST(FirstPart, ends_with_the_last_instant_of_its_time_and_has_two_at_the_least) {
  const rom::Network network = rom::tests::make_single_node();
  ThermalTest test = FittedNode::drive(network, 100.0);
  test.time_s.front() = -20.0;  // 120 s long
  for (Eigen::Index k = 0; k < test.measured_K.rows(); ++k) test.measured_K(k, 0) = static_cast<double>(k);
  const ThermalTest part = first_part(test, 0.5);  // to 40 s
  ASSERT_EQ(part.time_s.size(), 5U);
  EXPECT_EQ(part.time_s.back(), 40.0) << "the instant itself too";
  EXPECT_EQ(part.operating.size(), 5U);
  EXPECT_EQ(part.measured_K, test.measured_K.topRows(5));
  EXPECT_EQ(part.deformation_m.rows(), 5);
  EXPECT_EQ(part.name, test.name);
  EXPECT_EQ(first_part(test, 0.499).time_s.back(), 30.0);
  EXPECT_EQ(first_part(test, 0.0).time_s.size(), 2U);
  EXPECT_EQ(first_part(test, 1.0).time_s, test.time_s);
}

}  // namespace calibrate_fit_test
}  // namespace spindle_twin::correction::test
