#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_known_machine_test {

/// A twin that has followed a machine whose motor gives 1.6 times its heat and whose bearing half of it.
struct Experienced {
  explicit Experienced(const rom::Network& network) : pair(network, {}) {
    pair.truth[pair.parameter("heat motor")] = std::log(1.6);
    pair.truth[pair.parameter("heat bearing")] = std::log(0.5);
    pair.run_until(7200.0);
  }
  Pair pair;
};

KnownParameters known_of(const EstimatorCorrection& estimator) {
  EstimatorState state;
  estimator.save(state);
  return known_from(estimator.unknowns(), state).value();
}

TEST(KnownMachine, stays_and_what_is_of_the_day_does_not) {
  const rom::Network network = plates();
  const Experienced experienced(network);
  const KnownParameters known = known_of(experienced.pair.estimator);
  EstimatorCorrection next(network, {});
  const EstimatorCorrection fresh(network, {});
  const int taken = next.begin_with(known);
  next.reset(0.0, experienced.pair.twin.stepper.temperatures_K(), experienced.pair.operating);
  int machine = 0;
  for (Eigen::Index i = 0; i < next.parameters().count(); ++i) {
    const Parameter& parameter = next.parameters().list()[static_cast<std::size_t>(i)];
    const bool stays = is_of_the_machine(parameter.kind);
    machine += stays ? 1 : 0;
    const ParameterEstimate now = next.estimate(i), before = experienced.pair.estimator.estimate(i);
    EXPECT_NEAR(now.value, stays ? before.value : parameter.mean, 1e-12) << parameter.name;
    const double idle = fresh.covariance()(i, i);
    const double expected = stays ? std::min(before.deviation, parameter.deviation) : parameter.deviation;
    if (parameter.kind != ParameterKind::disturbance) {
      EXPECT_NEAR(now.deviation, expected, 1e-9 * expected) << parameter.name;
    } else {
      EXPECT_LE(now.deviation * now.deviation, idle * 1.001) << parameter.name;
    }
  }
  EXPECT_EQ(taken, machine + 4) << "and the lags of four sensors";
  EXPECT_EQ(next.record(0).offset_K, 0.0);
  const int motor = experienced.pair.parameter("heat motor");
  EXPECT_LT(next.estimate(motor).deviation, 0.5 * next.estimate(motor).prior_deviation);
  // The sum of two heats may be known better than either: their correlation is kept.
  const Eigen::MatrixXd a = next.covariance(), b = experienced.pair.estimator.covariance();
  const int bearing = experienced.pair.parameter("heat bearing");
  EXPECT_NEAR(a(motor, bearing), b(motor, bearing), 1e-9 * std::sqrt(b(motor, motor) * b(bearing, bearing)));
}

TEST(KnownMachine, is_begun_with_once) {
  const rom::Network network = plates();
  const Experienced experienced(network);
  const int motor = experienced.pair.parameter("heat motor");
  EstimatorCorrection next(network, {});
  ASSERT_GT(next.begin_with(known_of(experienced.pair.estimator)), 0);
  const Eigen::VectorXd& nodes_K = experienced.pair.twin.stepper.temperatures_K();
  next.reset(0.0, nodes_K, experienced.pair.operating);
  EXPECT_NEAR(next.estimate(motor).value, std::log(1.6), 0.2);
  next.reset(0.0, nodes_K, experienced.pair.operating);
  EXPECT_EQ(next.estimate(motor).value, next.parameters().mean()[motor]);
}

TEST(KnownMachine, keeps_watts_and_conductances_where_another_network_has_other_nominal_values) {
  const rom::Network network = plates();
  const Experienced experienced(network);
  rom::Network other = plates();
  for (rom::HeatSource& source : other.boundaries.sources) source.nominal_W *= 1.25;
  for (rom::Conductance& conductance : other.boundaries.conductances) conductance.nominal_W_per_m2K *= 0.8;
  EstimatorCorrection next(other, {});
  ASSERT_GT(next.begin_with(known_of(experienced.pair.estimator)), 0);
  next.reset(0.0, experienced.pair.twin.stepper.temperatures_K(), experienced.pair.operating);
  for (Eigen::Index i = 0; i < next.parameters().count(); ++i) {
    const Parameter& parameter = next.parameters().list()[static_cast<std::size_t>(i)];
    const double moved = next.estimate(i).value - experienced.pair.estimator.estimate(i).value;
    const double expected = parameter.kind == ParameterKind::heat   ? -std::log(1.25)
                            : parameter.kind == ParameterKind::film ? std::log(1.25)
                                                                    : 0.0;
    const bool compared = parameter.kind == ParameterKind::heat || parameter.kind == ParameterKind::film ||
                          parameter.kind == ParameterKind::speed_exponent;
    EXPECT_NEAR(compared ? moved : expected, expected, 1e-12) << parameter.name;
  }
}

TEST(KnownMachine, is_never_less_sure_than_the_priors_of_an_unknown_one) {
  const rom::Network network = plates();
  EstimatorCorrection filter(network, {});
  KnownParameters vague = known_of(filter);
  vague.covariance *= 9.0;
  EstimatorCorrection next(network, {});
  ASSERT_GT(next.begin_with(vague), 0);
  const Model at_rest(network);
  next.reset(0.0, at_rest.stepper.temperatures_K(), network.boundaries.operating);
  for (Eigen::Index i = 0; i < next.parameters().count(); ++i) {
    EXPECT_LE(next.estimate(i).deviation, next.estimate(i).prior_deviation * (1.0 + 1e-12)) << i;
  }
}

TEST(KnownMachine, of_which_a_number_is_none_or_no_name_fits_changes_nothing) {
  const rom::Network network = plates();
  const EstimatorCorrection filter(network, {});
  const KnownParameters good = known_of(filter);
  KnownParameters bad = good;
  bad.covariance(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(EstimatorCorrection(network, {}).begin_with(bad), 0);
  bad = good;
  bad.mean.conservativeResize(bad.mean.size() - 1);
  EXPECT_EQ(EstimatorCorrection(network, {}).begin_with(bad), 0);
  bad = good;
  for (std::string& name : bad.names) name += " of another machine";
  EXPECT_EQ(EstimatorCorrection(network, {}).begin_with(bad), 0);
  bad = good;
  bad.covariance(0, 0) = -1.0;
  EXPECT_EQ(EstimatorCorrection(network, {}).begin_with(bad), 0);
}

TEST(KnownMachine, that_was_calibrated_is_known_so_until_readings_contradict_it_twice_within_an_hour) {
  const rom::Network network = plates();
  auto test = std::make_shared<CalibratedPrior>();
  test->names = {"heat motor"};
  test->mean = Eigen::VectorXd::Constant(1, 0.1);
  test->covariance = Eigen::MatrixXd::Constant(1, 1, 0.01);
  EstimatorOptions options;
  options.priors.calibrated = test;
  Pair pair(network, options);
  const auto knows = [&] {
    EstimatorState state;
    pair.estimator.save(state);
    return state.knows_calibration;
  };
  pair.run_until(100.0);
  EXPECT_TRUE(knows());
  pair.estimator.note_contradiction();
  pair.run_until(200.0);
  EXPECT_TRUE(knows());
  pair.estimator.note_contradiction();
  pair.run_until(300.0);
  EXPECT_FALSE(knows());
  EstimatorState state;
  pair.estimator.save(state);
  pair.estimator.reset(0.0, pair.twin.stepper.temperatures_K(), pair.operating);
  EXPECT_TRUE(knows());
  ASSERT_TRUE(pair.estimator.restore(state));
  EXPECT_FALSE(knows()) << "a restart does not forget that";
}

TEST(KnownMachine, restored_with_other_priors_has_the_same_covariance) {
  const rom::Network network = plates();
  const Experienced experienced(network);
  EstimatorState state;
  experienced.pair.estimator.save(state);
  EstimatorOptions options;
  options.priors.heat = 0.25;
  EstimatorCorrection next(network, options);
  next.reset(0.0, experienced.pair.twin.stepper.temperatures_K(), experienced.pair.operating);
  ASSERT_TRUE(next.restore(state));
  const Eigen::MatrixXd before = experienced.pair.estimator.covariance();
  EXPECT_LT((next.covariance() - before).norm(), 1e-12 * before.norm());
}

}  // namespace estimator_known_machine_test
}  // namespace spindle_twin::correction::test
