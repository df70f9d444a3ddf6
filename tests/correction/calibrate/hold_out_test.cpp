#include "correction/calibrate/hold_out.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "correction/calibrate/calibrate.hpp"
#include "correction/calibrate/residual_covariance.hpp"
#include "tests/correction/calibrate/fitted_node.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_hold_out_test {

constexpr double before = 0.75;

TestFit fit_of_first_part(const FitTask& task) {
  std::vector<ThermalTest> seen;
  for (const ThermalTest& test : task.tests) seen.push_back(first_part(test, before));
  return fit_tests({task.network, task.predictor, task.options, seen}, nullptr, {});
}

/// Readings of both tests and what they may differ by before any of them is seen, one after the other.
struct AllReadings {
  AllReadings(const FitTask& task, const TestFit& seen) : at(judge_tests(task, seen.z, seen.covariance)) {
    const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests.size());
    Eigen::Index count = 0;
    for (const Eigen::VectorXd& left : at.left) count += left.size();
    Eigen::MatrixXd rows(count, unknowns.count());
    residual.resize(count);
    covariance = Eigen::MatrixXd::Zero(count, count);
    Eigen::Index first = 0;
    for (std::size_t test = 0; test < at.left.size(); ++test) {
      const Eigen::Index some = at.left[test].size();
      rows.middleRows(first, some) = unknowns.rows(at.readings[test], test);
      residual.segment(first, some) = at.left[test] + rows.middleRows(first, some) * (at.z - unknowns.mean());
      covariance.block(first, first, some, some) =
          residual_covariance(at.readings[test], task.predictor.parameters(), task.options);
      const double from_s = before * task.tests[test].length_s();
      for (Eigen::Index r = 0; r < some; ++r) {
        const bool is_seen = at.readings[test].readings[static_cast<std::size_t>(r)].time_s <= from_s;
        (is_seen ? known : held).push_back(first + r);
      }
      first += some;
    }
    const Eigen::MatrixXd open = rows * unknowns.root();
    covariance += open * open.transpose();
  }

  TestFit at;
  Eigen::VectorXd residual;
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Index> known, held;
};

TEST(HoldOut, mean_and_deviation_are_those_of_the_joint_normal_of_all_readings_given_the_first) {
  FittedNode node;
  node.options.sensor_error_K = 1e-3;  // not the larger part of it
  node.options.sensor_error_share = 0.01;
  const TestPredictor predictor(node.network, node.options);
  node.read(predictor, 0.05, 2e-6);
  const FitTask task{node.network, predictor, node.options, node.tests};
  const TestFit seen = fit_of_first_part(task);
  const AllReadings all(task, seen);
  const Eigen::MatrixXd of_known = all.covariance(all.known, all.known), mixed = all.covariance(all.held, all.known);
  const Eigen::LLT<Eigen::MatrixXd> root(of_known);
  const Eigen::VectorXd off = all.residual(all.held) - mixed * root.solve(all.residual(all.known));
  const Eigen::MatrixXd spread = all.covariance(all.held, all.held) - mixed * root.solve(mixed.transpose());
  const std::vector<ChannelFit> channels = hold_out(task, seen, before).channels;
  ASSERT_EQ(channels.size(), 4U) << "a sensor and a probe in each of two tests";
  const auto of_first_test = static_cast<Eigen::Index>(all.at.left[0].size());
  for (const ChannelFit& channel : channels) {
    Eigen::VectorXd share = Eigen::VectorXd::Zero(off.size());
    double rise = 0.0;
    for (std::size_t h = 0; h < all.held.size(); ++h) {
      const std::size_t test = all.held[h] < of_first_test ? 0 : 1;
      const auto place = static_cast<std::size_t>(all.held[h] - (test == 1 ? of_first_test : 0));
      const TestReading& reading = all.at.readings[test].readings[place];
      if (test != channel.test || reading.channel != channel.channel) continue;
      share[static_cast<Eigen::Index>(h)] = 1.0 / static_cast<double>(channel.readings);
      rise += reading.rise / static_cast<double>(channel.readings);
    }
    ASSERT_NEAR(share.sum(), 1.0, 1e-12);
    ASSERT_TRUE(channel.held_out);
    const double lasting = channel.channel == 0 ? 1e-6 + 1e-4 * rise * rise : 0.0;
    const double deviation = std::sqrt(share.dot(spread * share) + lasting);
    EXPECT_NEAR(channel.held_out->deviation, deviation, 1e-3 * deviation) << channel.name;
    EXPECT_NEAR(channel.held_out->off, share.dot(off), 0.02 * deviation) << channel.name;
  }
}

/// A node from the priors; its probe's zero creeps by options.probe_drift_m as it does in W.
std::vector<ThermalTest> drawn_tests(const FittedNode& node, const TestPredictor& predictor, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const CalibrateOptions& options = node.options;
  const TestUnknowns unknowns(node.network, predictor.parameters(), options, 1);
  Eigen::VectorXd u(unknowns.count());
  for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = normal(random);
  const Eigen::VectorXd z = unknowns.mean() + unknowns.root() * u;
  std::vector<ThermalTest> tests{FittedNode::drive(node.network, 4000.0)};
  CalibrateOptions each = options;
  each.interval_s = each.held_s = 0.0;
  const TestPrediction model =
      TestPredictor(node.network, each).predict(tests[0], unknowns.theta(z, 0), unknowns.lag_s(z));
  const double keep = std::exp(-10.0 / options.memory_s);
  double crept_m = options.probe_drift_m * normal(random);
  for (const TestReading& reading : model.readings) {
    const auto row = static_cast<Eigen::Index>(std::lround(reading.time_s / 10.0));
    const double zero = unknowns.offset(z, 0, reading.channel);
    if (reading.channel == 0) {
      tests[0].measured_K(row, 0) = -reading.residual + zero + options.sensors[0].noise_K * normal(random);
      continue;
    }
    crept_m = keep * crept_m + options.probe_drift_m * std::sqrt(1.0 - keep * keep) * normal(random);
    tests[0].deformation_m(row, 0) = -reading.residual + zero + crept_m + options.probe_noise_m * normal(random);
  }
  return tests;
}

TEST(HoldOut, means_of_machines_from_the_priors_spread_as_foreseen_and_a_probe_that_slips_is_told_from_them) {
  FittedNode node;
  const TestPredictor predictor(node.network, node.options);
  constexpr int machines = 60;
  double squares = 0.0;
  int told = 0;
  for (int machine = 0; machine < machines; ++machine) {
    std::vector<ThermalTest> tests = drawn_tests(node, predictor, 700 + static_cast<std::uint64_t>(machine));
    const FitTask task{node.network, predictor, node.options, tests};
    const TestFit seen = fit_of_first_part(task);
    const HeldOutMean probe = hold_out(task, seen, before).channels.back().held_out.value();
    squares += std::pow(probe.off / probe.deviation, 2);
    EXPECT_LT(std::abs(probe.off), 4.0 * probe.deviation) << "machine " << machine;
    tests[0].deformation_m.bottomRows(80).array() += 3e-6;
    const HeldOutMean slipped = hold_out(task, seen, before).channels.back().held_out.value();
    EXPECT_GT(slipped.off, probe.off);
    told += slipped.off > 3.0 * slipped.deviation ? 1 : 0;
  }
  const double spread = std::sqrt(squares / machines);  // of 60 draws within a fifth of 1, twice over
  EXPECT_GT(spread, 0.75);
  EXPECT_LT(spread, 1.25);
  EXPECT_GT(told, machines * 3 / 4);
}

/// A test of plates() with the parameters of `seed`, and a heat in its second group that no source explains.
ThermalTest recorded_with(const rom::Network& network, const CalibrateOptions& options, std::uint64_t seed,
                          double heat_W) {
  EstimatorPriors priors = options.priors;
  priors.disturbance = 0.01;
  const ParameterModel parameters(network, priors);
  Eigen::VectorXd truth = drawn(parameters, seed);
  for (Eigen::Index g = 0; g < parameters.group_count(); ++g) truth[parameters.disturbance(g)] = 0.0;
  truth[parameters.disturbance(1)] = heat_W;
  RecordedRun run;
  run.seed = seed + 1;
  return record(network, parameters, truth, run);
}

TEST(HoldOut, what_first_parts_and_the_last_ones_say_of_a_heat_is_together_what_all_readings_say) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const TestPredictor predictor(network, options);
  const std::vector<ThermalTest> tests{recorded_with(network, options, 31, 2.0),
                                       recorded_with(network, options, 31, 2.0)};
  const FitTask task{network, predictor, options, tests};
  const TestFit seen = fit_of_first_part(task);
  const HoldOut found = hold_out(task, seen, before);
  ASSERT_TRUE(found.heat);
  const AskedHeat &first = found.heat->before, &last = found.heat->after;
  const AllReadings all(task, seen);
  const HeatResponses responses = heat_responses(task, all.at);
  const auto group = std::find(responses.groups.begin(), responses.groups.end(), first.group);
  ASSERT_NE(group, responses.groups.end());
  EXPECT_EQ(last.group, first.group);
  Eigen::VectorXd response(all.residual.size());
  response << responses.of_test[0].col(group - responses.groups.begin()),
      responses.of_test[1].col(group - responses.groups.begin());
  const Eigen::VectorXd weighed = Eigen::LLT<Eigen::MatrixXd>(all.covariance).solve(response);
  const double before_per_W2 = std::pow(first.deviation_W, -2), after_per_W2 = std::pow(last.deviation_W, -2);
  EXPECT_NEAR(before_per_W2 + after_per_W2, weighed.dot(response), 1e-3 * weighed.dot(response));
  EXPECT_GT(after_per_W2, 0.005 * before_per_W2) << "the last parts tell something";
  EXPECT_NEAR(before_per_W2 * first.heat_W + after_per_W2 * last.heat_W, weighed.dot(all.residual),
              0.02 * std::sqrt(weighed.dot(response)));
}

TEST(HoldOut, reports_a_heat_that_both_parts_ask_for_beyond_their_limits_and_none_on_which_they_disagree) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const auto reported = [](const CalibrationResult& result) {
    return std::any_of(result.misfits.begin(), result.misfits.end(), [&](const std::string& misfit) {
      return misfit.starts_with("held out: before the last quarter readings ask for ") &&
             misfit.find(" in " + result.held_out.heat->before.group + " ") != std::string::npos;
    });
  };
  const std::vector<ThermalTest> with_heat{recorded_with(network, options, 63, 10.0)};
  CalibrateLimits limits;
  const CalibrationResult found = calibrate(network, options, with_heat, limits);
  ASSERT_TRUE(found.held_out.heat);
  const auto& [first, last] = *found.held_out.heat;
  EXPECT_NEAR(first.heat_W, 10.0, 3.0 * first.deviation_W);
  EXPECT_GT(first.deviations(), 3.0);
  EXPECT_GT(last.heat_W, 0.0);
  for (const double share : {0.999, 1.001}) {
    limits = {};
    limits.asked_after = share * last.deviations();
    EXPECT_EQ(reported(calibrate(network, options, with_heat, limits)), share < 1.0);
    limits.asked_after = 0.0;
    limits.asked_before = share * first.deviations();
    EXPECT_EQ(reported(calibrate(network, options, with_heat, limits)), share < 1.0);
  }
  limits.asked_before = limits.asked_after = 0.0;
  const CalibrationResult disagreeing = calibrate(network, options, {recorded_with(network, options, 62, 0.0)}, limits);
  ASSERT_LT(disagreeing.held_out.heat->before.heat_W * disagreeing.held_out.heat->after.heat_W, 0.0);
  EXPECT_FALSE(reported(disagreeing));
}

}  // namespace calibrate_hold_out_test
}  // namespace spindle_twin::correction::test
