#include "correction/estimator/factor_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/support/small_network.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace estimator_factor_spread_test {

/// The small network's parameters, the prior that follows from them, and an estimate of any covariance.
class Spread : public testing::Test {
 protected:
  Spread() {
    std::mt19937_64 random(20261124);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd root(parameters_.count(), parameters_.count());
    for (double& entry : root.reshaped()) entry = 0.1 * normal(random);
    covariance_ = root * root.transpose() + 0.01 * Eigen::MatrixXd::Identity(root.rows(), root.rows());
    filter_ = SquareRootFilter(parameters_.mean(), covariance_);
  }
  FactorKnowledge known() const { return {parameters_, prior_, filter_}; }

  rom::Network network_ = tests::small_network();
  ParameterModel parameters_{network_, {}};
  SquareRootFilter prior_{parameters_.mean(), parameters_.covariance()};
  Eigen::MatrixXd covariance_;
  SquareRootFilter filter_;
};

TEST_F(Spread, at_the_reference_speed_and_at_rest_the_prior_is_that_of_the_parameter_itself) {
  const double speed_rpm = network_.boundaries.reference_speed_rpm;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(network_.boundaries.sources.size()); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(parameters_.heat(i))];
    const FactorSpread spread = heat_spread(known(), i, speed_rpm, 0.0);
    EXPECT_NEAR(spread.prior_mean, parameter.mean, 1e-12);
    EXPECT_NEAR(spread.prior_deviation, parameter.deviation, 1e-12);
  }
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(network_.boundaries.conductances.size()); ++j) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(parameters_.conductance(j))];
    const FactorSpread spread = conductance_spread(known(), j);
    EXPECT_NEAR(spread.prior_mean, parameter.mean, 1e-12);
    EXPECT_NEAR(spread.prior_deviation, parameter.deviation, 1e-12);
    const Eigen::Index slot = parameters_.conductance(j);
    EXPECT_NEAR(spread.deviation, std::sqrt(covariance_(slot, slot)), 1e-12);
  }
}

TEST_F(Spread, speed_and_temperature_widen_a_heat_by_the_covariance_of_its_parameters) {
  const double speed_rpm = 2.5 * network_.boundaries.reference_speed_rpm, rise_K = 30.0;
  bool has_friction = false;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(network_.boundaries.sources.size()); ++i) {
    Eigen::VectorXd h = Eigen::VectorXd::Zero(parameters_.count());
    h[parameters_.heat(i)] = 1.0;
    if (parameters_.exponent(i) >= 0) h[parameters_.exponent(i)] = std::log(2.5);
    if (parameters_.is_friction(i)) h[parameters_.bearing()] = -rise_K;
    has_friction = has_friction || parameters_.is_friction(i);
    const FactorSpread spread = heat_spread(known(), i, speed_rpm, rise_K);
    EXPECT_NEAR(spread.deviation, std::sqrt(h.dot(covariance_ * h)), 1e-9);
    EXPECT_NEAR(spread.prior_deviation, std::sqrt(h.dot(parameters_.covariance() * h)), 1e-9);
    EXPECT_NEAR(spread.prior_mean, h.dot(parameters_.mean()), 1e-12);
    // What the factor would be with θ at the prior's mean.
    rom::CorrectionFactors factors = parameters_.make_factors(network_);
    Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(2);
    const Eigen::VectorXd rises_K = Eigen::VectorXd::Constant(factors.heat.size(), rise_K);
    parameters_.apply(parameters_.mean(), speed_rpm, rises_K, factors, bias_K);
    EXPECT_NEAR(std::exp(spread.prior_mean), factors.heat[i], 1e-12);
  }
  EXPECT_TRUE(has_friction);
}

TEST_F(Spread, a_factor_that_is_no_parameter_is_sure_to_be_1) {
  EstimatorPriors priors;
  priors.contact = priors.film = 0.0;
  const ParameterModel parameters(network_, priors);
  const SquareRootFilter prior(parameters.mean(), parameters.covariance());
  const FactorSpread spread = conductance_spread({parameters, prior, prior}, 0);
  EXPECT_EQ(spread.prior_mean, 0.0);
  EXPECT_EQ(spread.prior_deviation, 0.0);
  EXPECT_EQ(spread.deviation, 0.0);
}

TEST_F(Spread, is_told_without_the_heap) {
  const FactorKnowledge all = known();
  const long before = rom::tests::heap_calls();
  const double sum = heat_spread(all, 0, 3000.0, 10.0).deviation + conductance_spread(all, 1).deviation;
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
  EXPECT_GT(sum, 0.0);
}

}  // namespace estimator_factor_spread_test
}  // namespace spindle_twin::correction::test
