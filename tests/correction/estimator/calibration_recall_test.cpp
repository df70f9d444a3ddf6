#include "correction/estimator/calibration_recall.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_calibration_recall_test {

constexpr double day_s = 86400.0;

/// Two heats whose sum a test has told ten times better than either.
std::shared_ptr<const CalibratedPrior> calibrated(double correlation) {
  auto prior = std::make_shared<CalibratedPrior>();
  prior->origin = "a test";
  prior->names = {"heat motor", "heat bearing"};
  prior->mean = Eigen::Vector2d(0.3, -0.2);
  prior->covariance = Eigen::Matrix2d{{0.01, correlation * 0.01}, {correlation * 0.01, 0.01}};
  return prior;
}

/// Months of updates in which no sensor says anything.
struct Blind {
  Blind(const rom::Network& network, double correlation, double days, bool recalls) {
    EstimatorPriors priors;
    priors.calibrated = calibrated(correlation);
    const ParameterModel parameters(network, priors);
    filter = SquareRootFilter(parameters.mean(), parameters.covariance());
    CalibrationRecall recall(parameters, parameters.count());
    const Eigen::VectorXd keep = Eigen::VectorXd::Ones(parameters.count());
    Eigen::VectorXd growth = Eigen::VectorXd::Zero(parameters.count());
    constexpr double step_s = 60.0;
    for (const Eigen::Index i : parameters.calibrated_slots()) {
      growth[i] = std::pow(parameters.list()[static_cast<std::size_t>(i)].walk_per_root_s, 2.0) * step_s;
    }
    a = parameters.calibrated_slots()[0];
    b = parameters.calibrated_slots()[1];
    for (double time_s = 0.0; time_s < days * day_s; time_s += step_s) {
      filter.pass_time(parameters.mean(), keep, growth);
      if (recalls) recall.take_in(step_s, filter);
    }
  }
  SquareRootFilter filter;
  Eigen::Index a = 0, b = 0;
};

TEST(CalibrationRecall, a_parameter_that_nothing_else_tells_ends_at_twice_the_variance_of_its_test) {
  const rom::Network network = plates();
  const Blind month(network, 0.0, 60.0, true);
  EXPECT_NEAR(std::pow(month.filter.deviation(month.a), 2.0), 0.02, 0.0004);
  const Blind forgotten(network, 0.0, 60.0, false);
  // 0.1² and 0.003² a minute over 60 days.
  EXPECT_NEAR(std::pow(forgotten.filter.deviation(forgotten.a), 2.0), 0.01 + 0.003 * 0.003 * 1440.0 * 60.0, 1e-6);
}

/// Stationary P of P S P = q, S = d P₀⁻¹, q and d alike for both: P = √(q/d) P₀^½, direction by direction.
TEST(CalibrationRecall, what_was_known_of_a_sum_stays_known_better_than_its_parts) {
  const rom::Network network = plates();
  const double correlation = -0.98;
  const Blind month(network, correlation, 60.0, true);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(month.filter.size());
  sum[month.a] = sum[month.b] = 1.0;
  Blind copy = month;
  const double variance_of_sum = copy.filter.variance_of(sum);
  const double expected = 2.0 * 2.0 * 0.01 * std::sqrt(1.0 + correlation);  // 2 (√(q/d) √λ), λ = p₀ (1 + ρ), q/d = 4 p₀
  EXPECT_NEAR(variance_of_sum, expected, 0.05 * expected);
  EXPECT_GT(variance_of_sum, 2.0 * 0.01 * (1.0 + correlation)) << "but never better than the test told";
}

TEST(CalibrationRecall, a_mean_that_has_wandered_unseen_comes_back_and_one_that_is_measured_stays) {
  const rom::Network network = plates();
  EstimatorPriors priors;
  priors.calibrated = calibrated(0.0);
  const ParameterModel parameters(network, priors);
  CalibrationRecall recall(parameters, parameters.count());
  const Eigen::Index motor = parameters.calibrated_slots()[0], bearing = parameters.calibrated_slots()[1];
  SquareRootFilter filter(parameters.mean(), parameters.covariance());
  Eigen::VectorXd mean = filter.mean();
  mean[motor] = mean[bearing] = 0.8;
  filter.set_mean(mean);
  const Eigen::VectorXd keep = Eigen::VectorXd::Ones(parameters.count());
  Eigen::VectorXd growth = Eigen::VectorXd::Zero(parameters.count());
  const Eigen::VectorXd row = Eigen::VectorXd::Unit(parameters.count(), motor);
  constexpr double step_s = 60.0;
  for (const Eigen::Index i : {motor, bearing}) {
    growth[i] = std::pow(parameters.list()[static_cast<std::size_t>(i)].walk_per_root_s, 2.0) * step_s;
  }
  for (double time_s = 0.0; time_s < 60.0 * day_s; time_s += step_s) {
    filter.pass_time(parameters.mean(), keep, growth);
    recall.take_in(step_s, filter);
    filter.update(row, 0.8 - filter.mean()[motor], 0.01);  // once a minute to 0.1
  }
  EXPECT_NEAR(filter.mean()[motor], 0.8, 0.03);
  EXPECT_NEAR(filter.mean()[bearing], -0.2, 0.01);
}

/// The test's own information, as often a second as keeps twice its variance: 1/P grows by (walk / 2 p)² t.
TEST(CalibrationRecall, of_one_parameter_each_time_adds_what_keeps_twice_its_variance) {
  auto one = std::make_shared<CalibratedPrior>();
  one->names = {"heat motor"};
  one->mean = Eigen::VectorXd::Constant(1, 0.3);
  one->covariance = Eigen::MatrixXd::Constant(1, 1, 0.01);
  const rom::Network network = plates();
  EstimatorPriors priors;
  priors.calibrated = one;
  const ParameterModel parameters(network, priors);
  const Eigen::Index motor = parameters.calibrated_slots()[0];
  const double walk = parameters.list()[static_cast<std::size_t>(motor)].walk_per_root_s;
  CalibrationRecall recall(parameters, parameters.count());
  SquareRootFilter filter(parameters.mean(), parameters.covariance());
  double information = 1.0 / 0.01;
  for (const double elapsed_s : {6000.0, 12000.0, 0.0, -5.0}) {
    recall.take_in(elapsed_s, filter);
    information += std::pow(walk / (2.0 * 0.01), 2.0) * std::max(0.0, elapsed_s);
    EXPECT_NEAR(std::pow(filter.deviation(motor), 2.0), 1.0 / information, 1e-9 / information) << elapsed_s;
  }
  EXPECT_GT(information, 101.0);
}

TEST(CalibrationRecall, without_a_calibration_nothing_is_recalled) {
  const rom::Network network = plates();
  const ParameterModel parameters(network, {});
  CalibrationRecall recall(parameters, parameters.count());
  SquareRootFilter filter(parameters.mean(), parameters.covariance());
  const Eigen::MatrixXd before = filter.root();
  recall.take_in(60.0, filter);
  EXPECT_EQ(filter.root(), before);
}

}  // namespace estimator_calibration_recall_test
}  // namespace spindle_twin::correction::test
