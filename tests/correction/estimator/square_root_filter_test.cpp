#include "correction/estimator/square_root_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <random>
#include <stdexcept>

namespace spindle_twin::correction::test {
namespace estimator_square_root_filter_test {

Eigen::VectorXd random_vector(std::mt19937_64& random, Eigen::Index n) {
  std::normal_distribution<double> normal(0.0, 1.0);
  return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

Eigen::MatrixXd random_covariance(std::mt19937_64& random, Eigen::Index n) {
  Eigen::MatrixXd root(n, n);
  for (Eigen::Index i = 0; i < n; ++i) root.col(i) = random_vector(random, n);
  return root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
}

TEST(SquareRootFilter, scalar_after_scalar_gives_the_bayes_posterior_of_all_at_once) {
  constexpr Eigen::Index n = 12, measurements = 40;
  std::mt19937_64 random(3);
  const Eigen::VectorXd prior = random_vector(random, n);
  const Eigen::MatrixXd covariance = random_covariance(random, n);
  SquareRootFilter filter(prior, covariance);
  Eigen::MatrixXd information = covariance.inverse();
  Eigen::VectorXd weighted = information * prior;
  for (Eigen::Index k = 0; k < measurements; ++k) {
    const Eigen::VectorXd h = random_vector(random, n);
    const double noise = 0.05 + 0.01 * static_cast<double>(k);
    const double y = random_vector(random, 1)[0];
    information += h * h.transpose() / noise;
    weighted += h * y / noise;
    ASSERT_TRUE(filter.update(h, y - h.dot(filter.mean()), noise));
  }
  const Eigen::MatrixXd posterior = information.inverse();
  EXPECT_LT((filter.covariance() - posterior).norm(), 1e-10 * posterior.norm());
  EXPECT_LT((filter.mean() - posterior * weighted).norm(), 1e-10);
}

TEST(SquareRootFilter, time_adds_its_variance_and_forgets_towards_the_centre) {
  constexpr Eigen::Index n = 6;
  std::mt19937_64 random(5);
  const Eigen::VectorXd prior = random_vector(random, n), centre = random_vector(random, n);
  const Eigen::MatrixXd covariance = random_covariance(random, n);
  SquareRootFilter filter(prior, covariance);
  const Eigen::VectorXd keep = Eigen::VectorXd::LinSpaced(n, 0.5, 1.0),
                        growth = Eigen::VectorXd::LinSpaced(n, 0.0, 2.0);
  filter.pass_time(centre, keep, growth);
  Eigen::MatrixXd expected = keep.asDiagonal() * covariance * keep.asDiagonal();
  expected.diagonal() += growth;
  EXPECT_LT((filter.covariance() - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LT((filter.mean() - (centre + keep.cwiseProduct(prior - centre))).norm(), 1e-12);
}

TEST(SquareRootFilter, widening_scales_deviations_keeps_correlations_and_the_mean) {
  constexpr Eigen::Index n = 6;
  std::mt19937_64 random(13);
  const Eigen::VectorXd prior = random_vector(random, n);
  const Eigen::MatrixXd covariance = random_covariance(random, n);
  SquareRootFilter filter(prior, covariance);
  for (int k = 0; k < 8; ++k) filter.update(random_vector(random, n), 0.1, 0.05);
  const Eigen::VectorXd mean = filter.mean();
  const Eigen::MatrixXd narrow = filter.covariance();
  // Back to the deviations of the prior: loosening.
  Eigen::VectorXd factor(n);
  for (Eigen::Index i = 0; i < n; ++i) factor[i] = filter.scale()[i] / filter.deviation(i);
  ASSERT_GT(factor.maxCoeff(), 1.5);
  filter.widen(factor, Eigen::VectorXd::Zero(n));
  EXPECT_EQ(filter.mean(), mean);
  const Eigen::MatrixXd wide = filter.covariance();
  for (Eigen::Index i = 0; i < n; ++i) {
    EXPECT_NEAR(filter.deviation(i), std::sqrt(covariance(i, i)), 1e-12);
    for (Eigen::Index j = 0; j < i; ++j) {
      EXPECT_NEAR(wide(i, j) / std::sqrt(wide(i, i) * wide(j, j)),
                  narrow(i, j) / std::sqrt(narrow(i, i) * narrow(j, j)), 1e-10);
    }
  }
  // A factor of 0 cuts an entry off, the added variance is all that it has then.
  const Eigen::VectorXd cut = Eigen::VectorXd::Ones(n) - Eigen::VectorXd::Unit(n, 2);
  filter.widen(cut, 0.49 * Eigen::VectorXd::Unit(n, 2));
  Eigen::MatrixXd expected = wide;
  expected.row(2).setZero();
  expected.col(2).setZero();
  expected(2, 2) = 0.49;
  EXPECT_LT((filter.covariance() - expected).norm(), 1e-10 * expected.norm());
}

TEST(SquareRootFilter, covariance_stays_positive_over_three_days_of_nearly_perfect_readings) {
  constexpr Eigen::Index n = 20;
  constexpr int updates = 3 * 8640;
  std::mt19937_64 random(9);
  SquareRootFilter filter(Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd keep = Eigen::VectorXd::Ones(n);
  Eigen::VectorXd growth = Eigen::VectorXd::Constant(n, 1e-9);
  growth.tail(n / 2).setZero();
  const Eigen::VectorXd seen = random_vector(random, n);
  for (int k = 0; k < updates; ++k) {
    filter.pass_time(Eigen::VectorXd::Zero(n), keep, growth);
    // The same direction again and again, with a noise of a hundred thousandth of the prior.
    ASSERT_TRUE(filter.update(seen + 1e-3 * random_vector(random, n), 0.0, 1e-10));
  }
  const Eigen::MatrixXd covariance = filter.covariance();
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues();
  EXPECT_TRUE(covariance.allFinite());
  EXPECT_GT(values[0], -1e-16);
  for (Eigen::Index i = 0; i < n; ++i) EXPECT_GT(filter.deviation(i), 0.0);
}

TEST(SquareRootFilter, an_outputs_covariance_with_the_first_entries_is_that_of_the_whole_covariance) {
  std::mt19937_64 random(11);
  SquareRootFilter filter(random_vector(random, 7), random_covariance(random, 7));
  filter.update(random_vector(random, 7), 0.3, 0.1);
  const Eigen::VectorXd h = random_vector(random, 4);
  Eigen::VectorXd covariance(4);
  const double variance = filter.variance_of_first(h, covariance);
  const Eigen::MatrixXd all = filter.covariance().topLeftCorner(4, 4);
  EXPECT_LT((covariance - all * h).norm(), 1e-12 * covariance.norm());
  EXPECT_NEAR(variance, h.dot(all * h), 1e-12 * variance);
}

TEST(SquareRootFilter, refuses_what_is_no_covariance_and_what_is_no_measurement) {
  EXPECT_THROW(SquareRootFilter(Eigen::VectorXd::Zero(2), -Eigen::MatrixXd::Identity(2, 2)), std::invalid_argument);
  EXPECT_THROW(SquareRootFilter(Eigen::VectorXd::Zero(2), Eigen::MatrixXd::Identity(3, 3)), std::invalid_argument);
  const Eigen::Matrix2d certain = Eigen::Vector2d(1.0, 0.0).asDiagonal();
  try {
    const SquareRootFilter filter(Eigen::VectorXd::Zero(2), certain);
    ADD_FAILURE() << "a variance of 0 is taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "a covariance needs one positive variance per entry of the mean");
  }
  SquareRootFilter filter(Eigen::VectorXd::Zero(2), Eigen::MatrixXd::Identity(2, 2));
  const Eigen::VectorXd h = Eigen::VectorXd::Ones(2);
  EXPECT_FALSE(filter.update(h, std::numeric_limits<double>::quiet_NaN(), 1.0));
  EXPECT_FALSE(filter.update(h, 1.0, 0.0));
  EXPECT_EQ(filter.mean(), Eigen::VectorXd::Zero(2));
}

}  // namespace estimator_square_root_filter_test
}  // namespace spindle_twin::correction::test
