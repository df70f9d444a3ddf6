#include "correction/estimator/output_deviations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_output_deviations_test {

/// Only the heats are unknown, and nobody reads a sensor: the nose is a sum of lognormal heats, each times a constant.
EstimatorOptions only_heats(double curvature) {
  EstimatorOptions options;
  EstimatorPriors& priors = options.priors;
  priors.contact = priors.film = priors.environment_K = priors.bearing_per_K = priors.speed_exponent =
      priors.expansion = 0.0;
  priors.start_K = priors.disturbance = priors.heat_walk_per_root_min = 0.0;
  options.curvature = curvature;
  return options;
}

void run_unread(Pair& pair) {
  pair.valid.setConstant(false);
  pair.run_until(1800.0);
}

TEST(OutputDeviations, without_curvature_sigma_is_that_of_a_straight_line) {
  const rom::Network network = plates();
  Pair pair(network, only_heats(0.0));
  run_unread(pair);
  const Eigen::VectorXd slope = pair.estimator.sensitivities_K().transpose() * network.deformations[0].row_m_per_K;
  const double deviation_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_NEAR(deviation_m, EstimatorPriors{}.heat * slope.norm(), 1e-9 * deviation_m);
}

TEST(OutputDeviations, two_sigma_reach_the_end_of_the_longer_tail) {
  const rom::Network network = plates();
  Pair pair(network, only_heats(EstimatorOptions{}.curvature));
  run_unread(pair);
  const Eigen::VectorXd slope = pair.estimator.sensitivities_K().transpose() * network.deformations[0].row_m_per_K;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, EstimatorPriors{}.heat);
  std::vector<double> error_m(200000);
  for (double& error : error_m) {
    error = 0.0;
    // θ starts at the mean of the factor, σ²/2 above the median that is drawn from.
    for (const double one : slope) error += one * (std::exp(normal(random) - 0.125) - 1.0);
  }
  std::sort(error_m.begin(), error_m.end());
  const double beyond = 0.5 * std::erfc(std::sqrt(2.0));  // 2σ of a Gaussian
  const auto last = static_cast<double>(error_m.size() - 1);
  const double upper_m = error_m[static_cast<std::size_t>((1.0 - beyond) * last)];
  const double lower_m = -error_m[static_cast<std::size_t>(beyond * last)];
  const double longer_m = std::max(upper_m, lower_m);
  const double deviation_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_NEAR(2.0 * deviation_m, longer_m, 0.07 * longer_m);
  EXPECT_LT(2.0 * EstimatorPriors{}.heat * slope.norm(), 0.88 * longer_m) << "what a straight line would say";
}

TEST(OutputDeviations, of_a_maximum_where_all_points_are_equally_hot_do_not_hang_on_rounding) {
  const rom::Network network = plates();
  const auto deviations_K = [&](double rounding_K) {
    EstimatorCorrection estimator(network, EstimatorOptions{});
    Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 300.15);
    for (Eigen::Index i = 0; i < nodes_K.size(); ++i) nodes_K[i] += rounding_K * static_cast<double>(i);
    estimator.reset(0.0, nodes_K, network.boundaries.operating);
    return estimator.deviations().part_maximum_K;
  };
  const Eigen::VectorXd rising_K = deviations_K(1e-12), falling_K = deviations_K(-1e-12);
  for (Eigen::Index part = 0; part < rising_K.size(); ++part) EXPECT_NEAR(rising_K[part], falling_K[part], 1e-9);
}

}  // namespace estimator_output_deviations_test
}  // namespace spindle_twin::correction::test
