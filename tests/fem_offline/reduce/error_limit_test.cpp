#include "fem_offline/reduce/error_limit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace spindle_twin::fem_offline {
namespace error_limit_test {

using Draw = std::function<double(std::mt19937_64&)>;

/// In how many of 2000 certificates of `cases` cases the limit is exceeded by at most 5 % of all cases; `above`: the
/// share of all cases above an error.
double share_of_certificates_kept(int cases, const Draw& draw, const std::function<double(double)>& above) {
  std::mt19937_64 random(20261123);
  constexpr int certificates = 2000;
  int kept = 0;
  for (int c = 0; c < certificates; ++c) {
    std::vector<double> errors(static_cast<std::size_t>(cases));
    std::generate(errors.begin(), errors.end(), [&] { return draw(random); });
    kept += above(error_limit(errors)) <= 1.0 - limit_content ? 1 : 0;
  }
  return static_cast<double>(kept) / certificates;
}

double log_normal(std::mt19937_64& random) { return std::lognormal_distribution<double>(-3.0, 0.6)(random); }
double above_log_normal(double error) { return 0.5 * std::erfc((std::log(error) + 3.0) / 0.6 / std::sqrt(2.0)); }
double exponential(std::mt19937_64& random) { return std::exponential_distribution<double>(1.0)(random); }
double uniform(std::mt19937_64& random) { return std::uniform_real_distribution<double>(0.0, 1.0)(random); }

constexpr double chance = 0.015;  // three deviations of the share over 2000 certificates

TEST(ErrorLimit, ranks_are_those_of_the_tables) {
  for (const auto& [cases, rank] :
       {std::pair{10, 0}, {58, 0}, {59, 1}, {92, 1}, {93, 2}, {123, 2}, {124, 3}, {181, 5}}) {
    EXPECT_EQ(limiting_rank(cases), rank) << cases;
  }
  for (const auto& [cases, rank] : {std::pair{28, 0}, {29, 1}, {45, 1}, {46, 2}, {61, 3}, {64, 3}, {76, 4}}) {
    EXPECT_EQ(limiting_rank(cases, 0.9), rank) << cases;
  }
}

TEST(ErrorLimit, factors_of_a_normal_law_are_those_of_the_tables) {
  EXPECT_NEAR(normal_limit_factor(10), 2.911, 1e-3);
  EXPECT_NEAR(normal_limit_factor(20), 2.396, 1e-3);
  EXPECT_NEAR(normal_limit_factor(50), 2.065, 1e-3);
}

TEST(ErrorLimit, of_59_cases_keeps_its_promise_whatever_the_distribution) {
  EXPECT_GE(share_of_certificates_kept(59, log_normal, above_log_normal), limit_confidence - chance);
  EXPECT_GE(share_of_certificates_kept(59, exponential, [](double error) { return std::exp(-error); }),
            limit_confidence - chance);
  EXPECT_GE(share_of_certificates_kept(124, uniform, [](double error) { return 1.0 - error; }),
            limit_confidence - chance);
}

TEST(ErrorLimit, of_20_cases_keeps_its_promise_where_errors_are_log_normal_or_have_a_shorter_tail) {
  EXPECT_GE(share_of_certificates_kept(20, log_normal, above_log_normal), limit_confidence - chance);
  EXPECT_GE(share_of_certificates_kept(20, exponential, [](double error) { return std::exp(-error); }),
            limit_confidence - chance);
  EXPECT_GE(share_of_certificates_kept(20, uniform, [](double error) { return 1.0 - error; }),
            limit_confidence - chance);
}

TEST(ErrorLimit, knows_no_unit_and_is_none_of_too_few_cases_or_of_no_error) {
  std::mt19937_64 random(7);
  std::vector<double> errors(20), thousandths(20);
  std::generate(errors.begin(), errors.end(), [&] { return log_normal(random); });
  std::transform(errors.begin(), errors.end(), thousandths.begin(), [](double error) { return 1e-3 * error; });
  const double limit = error_limit(errors);
  EXPECT_NEAR(error_limit(thousandths), 1e-3 * limit, 1e-12);
  EXPECT_GE(limit, *std::max_element(errors.begin(), errors.end()));
  EXPECT_EQ(error_limit(std::vector<double>(20, 0.0)), 0.0);
  EXPECT_EQ(error_limit(std::vector<double>(fewest_limiting_cases - 1, 1.0)), 0.0);
  EXPECT_EQ(limit_rule(fewest_limiting_cases - 1).content, 0.0);
  EXPECT_TRUE(limit_rule(58).fitted);
  EXPECT_FALSE(limit_rule(59).fitted);
}

TEST(ErrorLimit, cases_above_it_are_counted_by_output) {
  rom::Network network;
  network.key_points.resize(2);
  network.key_points[0].name = "front";
  network.key_points[1].name = "rear";
  network.deformations.resize(1);
  network.deformations[0].name = "nose";
  network.certificate.key_points_K = {{1.0, 0.5, 0.0, 2.0}, {1.0, 0.5, 0.0, 0.0}};
  network.certificate.deformations_m = {{1e-9, 1e-9, 0.0, 2e-9}};
  Eigen::MatrixXd errors(3, 4);
  errors << 1.0, 2.1, 3.0, 2.0, 9.0, 9.0, 9.0, 9.0, 0.0, 0.0, 0.0, 3e-9;
  const LimitCheck check = check_limits(network, errors);
  EXPECT_EQ(check.outputs, (std::vector<std::string>{"key point front", "deformation nose"}));
  EXPECT_EQ(check.above, (std::vector<int>{2, 1}));
  EXPECT_DOUBLE_EQ(check.share(), 3.0 / 8.0);
}

}  // namespace error_limit_test
}  // namespace spindle_twin::fem_offline
