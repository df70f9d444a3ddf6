#include "correction/estimator/reduced_chi_square.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "correction/estimator/estimator_correction.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_reduced_chi_square_test {

struct Machines {
  rom::Network network = plates();
  ParameterModel parameters{network, {}};
  Eigen::VectorXd deviation = Eigen::VectorXd::Ones(parameters.count());

  Machines() {
    for (Eigen::Index i = 0; i < deviation.size(); ++i) deviation[i] = std::max(of(i).deviation, 1e-3);
  }
  const Parameter& of(Eigen::Index i) const { return parameters.list()[static_cast<std::size_t>(i)]; }
  SquareRootFilter unread() const { return {parameters.mean(), deviation.cwiseAbs2().asDiagonal().toDenseMatrix()}; }
  /// θ at so many deviations of every ln factor.
  Eigen::VectorXd off_by(double deviations) const {
    Eigen::VectorXd theta = parameters.mean();
    for (Eigen::Index i = 0; i < theta.size(); ++i) {
      if (bends_the_state(of(i).kind)) theta[i] += deviations * deviation[i];
    }
    return theta;
  }
  /// With θ there, and each deviation so many times that of the prior.
  SquareRootFilter at(double deviations, double width = 1.0) const {
    SquareRootFilter filter = unread();
    const Eigen::VectorXd all = Eigen::VectorXd::Ones(parameters.count());
    filter.widen(width * all, 0.0 * all);
    filter.set_mean(off_by(deviations));
    return filter;
  }
  double factors() const {
    double count = 0.0;
    for (Eigen::Index i = 0; i < parameters.count(); ++i) count += bends_the_state(of(i).kind) ? 1.0 : 0.0;
    return count;
  }
};

TEST(ReducedChiSquare, has_the_mean_1_over_machines_of_the_prior_however_much_was_read) {
  const Machines machines;
  constexpr unsigned seed = 3;
  constexpr int count = 2000;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (const int readings : {1, 3, 8}) {
    double sum = 0.0, determined = 0.0;
    for (int machine = 0; machine < count; ++machine) {
      SquareRootFilter filter = machines.unread();
      Eigen::VectorXd truth = machines.parameters.mean();
      for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] += machines.deviation[i] * normal(random);
      for (int reading = 0; reading < readings; ++reading) {
        Eigen::VectorXd row(truth.size());
        for (Eigen::Index i = 0; i < row.size(); ++i) row[i] = normal(random) / machines.deviation[i];
        filter.update(row, row.dot(truth - filter.mean()) + 0.1 * normal(random), 0.01);
      }
      double chi_square = 0.0;
      for (Eigen::Index i = 0; i < truth.size(); ++i) {
        if (!bends_the_state(machines.of(i).kind)) continue;
        chi_square += std::pow((filter.mean()[i] - machines.parameters.mean()[i]) / machines.deviation[i], 2.0);
      }
      ReducedChiSquare likely;
      likely.note(machines.parameters, filter);
      sum += chi_square;
      determined += likely.determined();
    }
    EXPECT_NEAR(sum / determined, 1.0, 0.06) << readings << " readings a machine, seed " << seed;
  }
}

TEST(ReducedChiSquare, of_a_machine_further_out_is_what_one_sigma_counts_times) {
  const Machines machines;
  ReducedChiSquare likely;
  likely.note(machines.parameters, machines.at(2.0, 0.5));
  EXPECT_NEAR(likely.determined(), 0.75 * machines.factors(), 1e-9 * machines.factors()) << "of each variance";
  EXPECT_NEAR(likely.scale_factor(), std::sqrt(4.0 / 0.75), 1e-9);
  likely.note(machines.parameters, machines.at(0.5, 0.5));
  EXPECT_DOUBLE_EQ(likely.scale_factor(), 1.0) << "a likely machine is not told surer than its covariance says";
}

TEST(ReducedChiSquare, is_of_what_was_determined_before_a_loosening_too) {
  const Machines machines;
  ReducedChiSquare likely;
  likely.note(machines.parameters, machines.at(2.0, 0.5));
  const double before = likely.scale_factor();
  likely.note(machines.parameters, machines.at(2.0));
  EXPECT_DOUBLE_EQ(likely.scale_factor(), before);
  likely.restart();
  likely.note(machines.parameters, machines.at(0.0));
  EXPECT_DOUBLE_EQ(likely.scale_factor(), 1.0);
}

TEST(ReducedChiSquare, of_the_readings_widens_by_the_fourth_root_of_what_they_exceed) {
  const Machines machines;
  ReducedChiSquare likely;
  likely.note(machines.parameters, machines.at(0.0), 81.0);
  EXPECT_DOUBLE_EQ(likely.scale_factor(), 3.0);
  likely.note(machines.parameters, machines.at(0.0), 0.5);
  EXPECT_DOUBLE_EQ(likely.scale_factor(), 1.0) << "readings that are met better than expected make nothing surer";
}

TEST(ReducedChiSquare, of_one_machine_in_a_thousand_makes_it_an_unlikely_one) {
  const Machines machines;
  // Abramowitz and Stegun, Handbook of Mathematical Functions, table 26.8, Q = 0.001.
  for (const auto& [degrees, quantile] : {std::pair{1.0, 10.828}, {3.0, 16.266}, {6.0, 22.458}}) {
    ASSERT_LT(degrees, machines.factors());
    const double width = std::sqrt(1.0 - degrees / machines.factors());
    for (const double of_limit : {0.95, 1.05}) {
      const double deviations = std::sqrt(of_limit * quantile / machines.factors());
      EXPECT_EQ(is_unlikely_machine(machines.parameters, machines.at(deviations, width)), of_limit > 1.0) << degrees;
    }
  }
}

TEST(ReducedChiSquare, says_nothing_of_factors_that_no_reading_has_determined) {
  const Machines machines;
  ReducedChiSquare likely;
  likely.note(machines.parameters, machines.at(0.5));
  EXPECT_DOUBLE_EQ(likely.scale_factor(), 1.0) << "as after standing by, at factors of 1";
}

/// With all heats five deviations off, which no prior makes likely, every published deviation grows.
TEST(ReducedChiSquare, of_the_estimate_widens_what_is_published_and_is_remembered) {
  const rom::Network network = plates();
  Pair pair(network, EstimatorOptions{});
  pair.run_until(1800.0);
  const double usual_m = pair.estimator.deviations().deformations_m[0];
  EstimatorState state;
  pair.estimator.save(state);
  EXPECT_GT(state.determined, 0.5);
  Eigen::VectorXd theta = pair.estimator.parameters().mean();
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const Parameter& parameter = pair.estimator.parameters().list()[static_cast<std::size_t>(i)];
    if (parameter.kind == ParameterKind::heat) theta[i] += 5.0 * parameter.deviation;
  }
  for (Eigen::Index i = 0; i < theta.size(); ++i) state.mean[static_cast<std::size_t>(i)] = theta[i];
  ASSERT_TRUE(pair.estimator.restore(state));
  EXPECT_GT(pair.estimator.deviations().deformations_m[0], 1.5 * usual_m);
  state.determined += 40.0;
  ASSERT_TRUE(pair.estimator.restore(state));
  EstimatorState again;
  pair.estimator.save(again);
  EXPECT_DOUBLE_EQ(again.determined, state.determined) << "what was determined before the restart counts";
  state.determined = -1.0;
  EXPECT_FALSE(pair.estimator.restore(state)) << "no count of factors";
}

}  // namespace estimator_reduced_chi_square_test
}  // namespace spindle_twin::correction::test
