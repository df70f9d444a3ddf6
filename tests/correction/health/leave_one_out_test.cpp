#include "correction/health/leave_one_out.hpp"

#include <gtest/gtest.h>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace {

/// Plant and twin, and the filters that leave one sensor out.
struct Watched {
  explicit Watched(const rom::Network& network, const EstimatorOptions& options = {})
      : pair(network, options), bank(pair.estimator) {
    pair.noise_K = 0.03;
    pair.truth[0] = 0.3;
  }
  void run_until(double end_s) {
    while (pair.time_s < end_s) {
      pair.cycle();
      if (pair.estimator.updates() == updates) continue;
      updates = pair.estimator.updates();
      bank.update(pair.estimator);
    }
  }
  Pair pair;
  LeaveOneOut bank;
  long updates = 0;
};

TEST(LeaveOneOut, healthy_sensors_agree_with_all_others) {
  const rom::Network network = plates();
  Watched watched(network);
  double most = 0.0;
  for (double end_s = 600.0; end_s <= 7200.0; end_s += 60.0) {
    watched.run_until(end_s);
    for (Eigen::Index s = 0; s < watched.pair.measured_K.size(); ++s) {
      ASSERT_TRUE(watched.bank.misfit(s).judged);
      most = std::max(most, std::abs(watched.bank.misfit(s).ratio()));
    }
  }
  EXPECT_LT(most, 2.2);
}

TEST(LeaveOneOut, of_three_neighbours_the_drifting_one_contradicts_the_others_first) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.sensors = key_point_sensors(network, options);
  const EstimatorSensor first_plate = options.sensors.front();
  options.sensors.insert(options.sensors.end(), 2, first_plate);
  for (const Eigen::Index drifting : {0, 4, 5}) {
    Watched watched(network, options);
    watched.pair.tamper = [&](Eigen::VectorXd& readings_K) {
      readings_K[drifting] += 1.0 / 3600.0 * std::max(0.0, watched.pair.time_s - 600.0);
    };
    Eigen::Index first = -1;
    while (first < 0 && watched.pair.time_s < 7200.0) {
      watched.run_until(watched.pair.time_s + 10.0);
      for (Eigen::Index s = 0; s < 6; ++s) {
        if (std::abs(watched.bank.misfit(s).ratio()) > 3.0) first = s;
      }
    }
    EXPECT_EQ(first, drifting) << "at " << watched.pair.time_s << " s";
    EXPECT_LT(watched.pair.time_s, 600.0 + 1800.0) << "half a kelvin";
    EXPECT_GT(watched.bank.misfit(drifting).misfit_K, 0.0);
  }
}

TEST(LeaveOneOut, a_filter_without_a_sensor_is_the_estimator_that_never_saw_it) {
  const rom::Network network = plates();
  Watched watched(network);
  Pair blind(network, {});
  blind.noise_K = 0.03;
  blind.truth = watched.pair.truth;
  blind.valid[1] = false;
  watched.run_until(1800.0);
  blind.run_until(1800.0);
  const SquareRootFilter& without = watched.bank.without(1);
  for (Eigen::Index i = 0; i < watched.pair.estimator.parameters().count(); ++i) {
    const ParameterEstimate expected = blind.estimator.estimate(i);
    EXPECT_NEAR(without.mean()[i], expected.value, 0.5 * expected.deviation);
    EXPECT_NEAR(without.deviation(i), expected.deviation, 0.1 * expected.deviation);
  }
}

TEST(LeaveOneOut, taking_over_a_filter_moves_the_state_with_it) {
  const rom::Network network = plates();
  Watched watched(network);
  watched.pair.tamper = [&](Eigen::VectorXd& readings_K) { readings_K[3] += watched.pair.time_s / 1800.0; };
  watched.run_until(3600.0);
  EstimatorCorrection& estimator = watched.pair.estimator;
  const Eigen::VectorXd before_K = estimator.corrected_nodes_K();
  const Eigen::VectorXd step =
      (watched.bank.without(3).mean() - estimator.filter().mean()).head(estimator.parameters().count());
  const Eigen::MatrixXd sensitivities = estimator.sensitivities_K();
  estimator.adopt(watched.bank.without(3), watched.pair.operating);
  EXPECT_LT((estimator.corrected_nodes_K() - watched.pair.twin.stepper.temperatures_K() - sensitivities * step)
                .lpNorm<Eigen::Infinity>(),
            1.0);
  EXPECT_TRUE(estimator.filter().mean().isApprox(watched.bank.without(3).mean(), 1e-12));
  EXPECT_GT((estimator.corrected_nodes_K() - before_K).norm(), 0.0);
}

TEST(LeaveOneOut, an_open_suspicion_widens_what_is_published) {
  const rom::Network network = plates();
  Watched watched(network);
  watched.run_until(1800.0);
  EstimatorCorrection& estimator = watched.pair.estimator;
  const double before_m = estimator.deviations().deformations_m[0];
  Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(estimator.parameters().count(), 4);
  steps(0, 2) = 1.0;
  estimator.set_alternatives(steps);
  watched.run_until(1812.0);
  const double nose_m = network.deformations[0].row_m_per_K.dot(estimator.sensitivities_K().col(0));
  EXPECT_NEAR(estimator.deviations().deformations_m[0], std::hypot(before_m, nose_m), 0.05 * std::abs(nose_m));
}

TEST(LeaveOneOut, update_never_calls_the_heap) {
  const rom::Network network = plates();
  Watched watched(network);
  watched.run_until(60.0);
  const long before = rom::tests::heap_calls();
  watched.bank.update(watched.pair.estimator);
  watched.pair.estimator.set_alternatives(watched.bank.alternatives(watched.pair.estimator));
  watched.bank.widen_offset(watched.pair.estimator, 1, 0.2);
  watched.pair.estimator.widen_offset(1, 0.2);
  watched.pair.estimator.adopt(watched.bank.without(2), watched.pair.operating);
  watched.bank.settle_on(2);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace
}  // namespace spindle_twin::correction::test
