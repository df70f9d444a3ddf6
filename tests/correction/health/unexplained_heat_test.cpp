#include "correction/health/unexplained_heat.hpp"

#include <gtest/gtest.h>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace health_unexplained_heat_test {

/// Plant and twin of a certified network, and the second filter.
struct Suspected {
  explicit Suspected(const rom::Network& network, double heat_W) : pair(network, {}), second(pair.estimator) {
    pair.noise_K = 0.03;
    pair.truth = pair.estimator.parameters().mean();
    pair.truth[pair.parameter("unexplained heat plate 1")] = heat_W;
    pair.cycle();
    second.follow(pair.estimator);
  }
  /// Until there is evidence enough.
  bool run_until(double end_s) {
    while (pair.time_s < end_s) {
      const double in_programme_s = std::fmod(pair.time_s, 2400.0);
      pair.operating.speed_rpm = in_programme_s < 1200.0 ? 6000.0 : 1500.0;
      pair.cycle();
      const long begun = pair.estimator.loosened() + pair.estimator.relinearised();
      if (begun != begun_anew) {
        begun_anew = begun;
        second.follow(pair.estimator);
      }
      if (pair.estimator.updates() == updates) continue;
      updates = pair.estimator.updates();
      enough = second.update(pair.estimator);
      largest = std::max(largest, second.evidence());
      if (enough) break;
    }
    return enough;
  }
  Pair pair;
  UnexplainedHeat second;
  long updates = 0, begun_anew = 0;
  double largest = 0.0;
  bool enough = false;
};

TEST(UnexplainedHeat, following_makes_the_heats_as_wide_as_open_ones_and_leaves_all_else) {
  const rom::Network network = plates();
  Suspected suspected(network, 0.0);
  EXPECT_EQ(suspected.second.evidence(), 0.0);
  suspected.run_until(600.0);
  const EstimatorCorrection& estimator = suspected.pair.estimator;
  suspected.second.follow(estimator);
  EXPECT_EQ(suspected.second.evidence(), 0.0);
  EXPECT_EQ(suspected.second.filter().mean(), estimator.filter().mean());
  const ParameterModel& parameters = estimator.parameters();
  ASSERT_GT(parameters.group_count(), 1);
  EXPECT_FALSE(estimator.heats_are_open());
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const double deviation = suspected.second.filter().deviation(i);
    if (parameter.kind == ParameterKind::disturbance) {
      EXPECT_NEAR(deviation, estimator.open_heat_W(parameter.index), 1e-9 * deviation) << parameter.name;
      EXPECT_LT(estimator.filter().deviation(i), 0.01 * deviation) << parameter.name;
    } else {
      EXPECT_NEAR(deviation, estimator.filter().deviation(i), 1e-9 * deviation) << parameter.name;
    }
  }
}

TEST(UnexplainedHeat, evidence_rises_with_a_true_one_and_not_without) {
  const rom::Network network = plates();
  Suspected healthy(network, 0.0);
  EXPECT_FALSE(healthy.run_until(3.0 * 3600.0));
  EXPECT_LT(healthy.largest, 10.0);
  // It comes when the parameters have been learnt.
  Suspected heated(network, 0.0);
  heated.run_until(2400.0);
  heated.pair.truth[heated.pair.parameter("unexplained heat plate 1")] = 40.0;
  heated.run_until(2.0 * 3600.0);
  EXPECT_GT(heated.largest, 2.0 * healthy.largest);
  EXPECT_GT(heated.largest, 10.0);
}

TEST(UnexplainedHeat, evidence_is_what_an_update_surprises_the_estimator_more_than_open_heats_and_fades_in_an_hour) {
  const rom::Network network = plates();
  Suspected suspected(network, 0.0);
  suspected.run_until(2402.0);
  const EstimatorCorrection& estimator = suspected.pair.estimator;
  const double before = suspected.second.evidence();
  ASSERT_GT(std::abs(before), 0.5) << "something is there to fade";
  SquareRootFilter open = suspected.second.filter();
  suspected.run_until(2412.0);
  const EstimatorUpdate& made = estimator.last_update();
  ASSERT_EQ(made.elapsed_s, 10.0);
  const ParameterModel& parameters = estimator.parameters();
  const Eigen::Index n = made.unknowns.size(), sensors = made.innovation_K.size();
  Eigen::VectorXd keep(n), growth = Eigen::VectorXd::Zero(n);
  estimator.passing_of_time(made.elapsed_s, keep, growth);
  for (Eigen::Index g = 0; g < parameters.group_count(); ++g) {
    const Eigen::Index slot = parameters.disturbance(g);
    growth[slot] = std::pow(estimator.open_heat_W(g), 2.0) * (1.0 - keep[slot] * keep[slot]);
  }
  open.pass_time(estimator.prior().mean(), keep, growth);
  double shut = 0.0;
  // All sensors at once, by their joint covariance, instead of one after the other.
  const Eigen::MatrixXd rows = made.rows.leftCols(sensors).transpose();
  Eigen::MatrixXd joint_K2 = rows * open.covariance() * rows.transpose();
  Eigen::VectorXd innovation_K(sensors);
  for (Eigen::Index s = 0; s < sensors; ++s) {
    shut += std::pow(estimator.record(s).innovation_K, 2) / estimator.record(s).variance_K2;
    innovation_K[s] = made.innovation_K[s] - rows.row(s).dot(open.mean() - made.unknowns);
    joint_K2(s, s) += made.noise_K2[s];
  }
  const double with_open_heats = innovation_K.dot(joint_K2.llt().solve(innovation_K));
  EXPECT_NEAR(suspected.second.evidence(), std::exp(-10.0 / 3600.0) * before + shut - with_open_heats, 1e-9);
}

TEST(UnexplainedHeat, opened_heats_are_those_of_the_second_filter) {
  const rom::Network network = plates();
  Suspected suspected(network, 0.0);
  suspected.run_until(2400.0);
  EstimatorCorrection& estimator = suspected.pair.estimator;
  ASSERT_FALSE(estimator.heats_are_open());
  estimator.open_heats(suspected.second.filter(), suspected.pair.operating);
  EXPECT_TRUE(estimator.heats_are_open());
  EXPECT_EQ(estimator.filter().mean(), suspected.second.filter().mean());
  EXPECT_EQ(estimator.covariance(), suspected.second.filter().covariance());
  const ParameterEstimate heat = estimator.estimate(suspected.pair.parameter("unexplained heat plate 1"));
  EXPECT_GT(heat.deviation, 0.1 * heat.prior_deviation);
}

TEST(UnexplainedHeat, update_and_follow_never_call_the_heap) {
  const rom::Network network = plates();
  Suspected suspected(network, 0.0);
  suspected.run_until(60.0);
  const long before = rom::tests::heap_calls();
  suspected.second.update(suspected.pair.estimator);
  suspected.second.follow(suspected.pair.estimator);
  suspected.pair.estimator.open_heats(suspected.second.filter(), suspected.pair.operating);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace health_unexplained_heat_test
}  // namespace spindle_twin::correction::test
