#include "correction/health/leave_one_out.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace health_leave_one_out_test {

/// Plant and twin, and the filters that leave one sensor out.
struct Watched {
  explicit Watched(const rom::Network& network, const EstimatorOptions& options = {})
      : pair(network, options), bank(pair.estimator) {
    pair.noise_K = 0.03;
    pair.truth[0] = 0.3;
  }
  void run_until(double end_s) {
    while (pair.time_s < end_s) {
      if (in_steps) pair.operating.speed_rpm = std::fmod(pair.time_s, 1800.0) < 900.0 ? 6000.0 : 1500.0;
      pair.cycle();
      if (pair.estimator.updates() == updates) continue;
      updates = pair.estimator.updates();
      bank.update(pair.estimator);
      if (doubts) pair.estimator.set_alternatives(bank.alternatives(pair.estimator));
      if (each) each();
    }
  }
  /// The sensor against which there is evidence enough, and 8 more than against any other; -1: none.
  Eigen::Index contradicted() const {
    double most = 0.0, next = 0.0;
    Eigen::Index worst = -1;
    for (Eigen::Index s = 0; s < pair.measured_K.size(); ++s) {
      const double evidence = bank.misfit(s).evidence;
      next = std::max(next, std::min(most, evidence));
      if (evidence <= most) continue;
      most = evidence;
      worst = s;
    }
    return most > 30.0 && most - next > 8.0 ? worst : -1;
  }
  Pair pair;
  LeaveOneOut bank;
  long updates = 0;
  bool doubts = false;         ///< goes into what is published
  bool in_steps = false;       ///< the speed
  std::function<void()> each;  ///< after an update
};

TEST(LeaveOneOut, healthy_sensors_agree_with_all_others) {
  const rom::Network network = plates();
  Watched watched(network);
  double most = 0.0, most_evidence = 0.0;
  for (double end_s = 600.0; end_s <= 7200.0; end_s += 60.0) {
    watched.run_until(end_s);
    for (Eigen::Index s = 0; s < watched.pair.measured_K.size(); ++s) {
      ASSERT_TRUE(watched.bank.misfit(s).judged);
      most = std::max(most, std::abs(watched.bank.misfit(s).ratio()));
      most_evidence = std::max(most_evidence, watched.bank.misfit(s).evidence);
    }
  }
  EXPECT_LT(most, 2.2);
  EXPECT_LT(most_evidence, 15.0) << "half of what fails a channel";
}

TEST(LeaveOneOut, evidence_is_what_an_update_surprises_all_less_what_it_surprises_all_others_and_fades) {
  const rom::Network network = plates();
  for (const double begin_s : {52.0, 182.0, 902.0, 4502.0}) {
    Watched watched(network);
    watched.run_until(begin_s);
    const EstimatorCorrection& estimator = watched.pair.estimator;
    const double before = watched.bank.misfit(1).evidence;
    SquareRootFilter without = watched.bank.without(1);
    watched.run_until(begin_s + 10.0);
    ASSERT_EQ(estimator.last_update().elapsed_s, 10.0);
    const EstimatorUpdate& made = estimator.last_update();
    double all = 0.0, others = 0.0;
    for (Eigen::Index s = 0; s < 4; ++s) {
      all += std::pow(estimator.record(s).innovation_K, 2) / estimator.record(s).variance_K2;
    }
    // The other three at once, by their joint covariance, instead of one after the other.
    const Eigen::Index n = made.unknowns.size();
    Eigen::VectorXd keep(n), growth = Eigen::VectorXd::Zero(n);
    estimator.passing_of_time(made.elapsed_s, keep, growth);
    without.pass_time(estimator.prior().mean(), keep, growth);
    const Eigen::Index kept = watched.pair.measured_K.size() - 1;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kept, n);
    Eigen::VectorXd innovation_K(kept);
    Eigen::Index at = 0;
    for (const Eigen::Index s : {0, 2, 3}) {
      rows.row(at) = made.rows.col(s).transpose();
      innovation_K[at] = made.innovation_K[s] - rows.row(at).dot(without.mean() - made.unknowns);
      ++at;
    }
    Eigen::MatrixXd joint_K2 = rows * without.covariance() * rows.transpose();
    at = 0;
    for (const Eigen::Index s : {0, 2, 3}) joint_K2(at, at) += made.noise_K2[s], ++at;
    others = innovation_K.dot(joint_K2.llt().solve(innovation_K));
    const double memory_s = std::clamp(begin_s + 8.0, 120.0, 3600.0);  // all of it, two minutes to an hour
    EXPECT_NEAR(watched.bank.misfit(1).evidence, std::exp(-10.0 / memory_s) * before + all - others, 1e-9);
  }
}

TEST(LeaveOneOut, until_a_drift_is_found_the_band_holds_the_truth) {
  const rom::Network network = plates();
  for (const double rate_K_per_h : {-2.0, 0.5, 1.0, 5.0}) {
    for (Eigen::Index drifting = 0; drifting < 4; ++drifting) {
      Watched watched(network);
      watched.doubts = watched.in_steps = true;
      watched.pair.tamper = [&](Eigen::VectorXd& readings_K) {
        readings_K[drifting] += rate_K_per_h / 3600.0 * std::max(0.0, watched.pair.time_s - 600.0);
      };
      int cycles = 0, inside = 0;
      while (watched.contradicted() < 0 && watched.pair.time_s < 10800.0) {
        watched.run_until(watched.pair.time_s + 10.0);
        const double deviation_m = watched.pair.estimator.deviations().deformations_m[0];
        inside += std::abs(watched.pair.nose_error_m()) <= 2.0 * deviation_m ? 1 : 0;
        ++cycles;
      }
      EXPECT_GT(inside, 0.93 * cycles) << rate_K_per_h << " K/h at sensor " << drifting;
    }
  }
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
    while (watched.contradicted() < 0 && watched.pair.time_s < 7200.0) {
      watched.run_until(watched.pair.time_s + 10.0);
    }
    EXPECT_EQ(watched.contradicted(), drifting) << "at " << watched.pair.time_s << " s";
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
  Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(estimator.parameters().count(), 5);
  steps(0, 2) = 1.0;
  estimator.set_alternatives(steps);
  watched.run_until(1812.0);
  const double nose_m = network.deformations[0].row_m_per_K.dot(estimator.sensitivities_K().col(0));
  EXPECT_NEAR(estimator.deviations().deformations_m[0], std::hypot(before_m, nose_m), 0.05 * std::abs(nose_m));
}

TEST(LeaveOneOut, going_back_is_to_what_was_known_ten_to_fifteen_minutes_ago_and_less_sure) {
  const rom::Network network = plates();
  for (const double end_s : {2702.0, 2852.0, 2992.0}) {
    Watched watched(network);
    EstimatorCorrection& estimator = watched.pair.estimator;
    double age_s = -1.0, deviation = 0.0;
    std::vector<std::pair<double, double>>
        known;  // time, ln factor of the first heat, which has no memory of its prior
    std::vector<double> deviations;
    watched.each = [&] {
      known.emplace_back(watched.pair.time_s, estimator.filter().mean()[0]);
      deviations.push_back(estimator.filter().deviation(0));
    };
    watched.run_until(end_s);
    const SquareRootFilter& before = watched.bank.before(estimator);
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (known[i].second != before.mean()[0]) continue;
      age_s = known.back().first - known[i].first;
      deviation = deviations[i];
    }
    EXPECT_TRUE(age_s >= 600.0 && age_s < 910.0) << age_s;
    EXPECT_GT(before.deviation(0), deviation);
  }
}

TEST(LeaveOneOut, doubt_opens_from_evidence_of_four_to_twelve) {
  EXPECT_EQ(LeaveOneOut::weight_of(-100.0), 0.0);
  EXPECT_EQ(LeaveOneOut::weight_of(4.0), 0.0);
  EXPECT_EQ(LeaveOneOut::weight_of(6.0), 0.25);
  EXPECT_EQ(LeaveOneOut::weight_of(8.0), 0.5);
  EXPECT_EQ(LeaveOneOut::weight_of(12.0), 1.0);
  EXPECT_EQ(LeaveOneOut::weight_of(100.0), 1.0);
}

/// One sensor that drifts by 10 K/h, until there is evidence of 6 against it.
struct Drifting : Watched {
  Drifting(const rom::Network& network, Eigen::Index sensor) : Watched(network) {
    pair.tamper = [=, this](Eigen::VectorXd& readings_K) {
      readings_K[sensor] += 10.0 / 3600.0 * std::max(0.0, pair.time_s - 600.0);
    };
    while (bank.misfit(sensor).evidence < 6.0 && pair.time_s < 7200.0) run_until(pair.time_s + 10.0);
  }
};

TEST(LeaveOneOut, what_each_sensor_would_change_has_its_weight_and_no_sensor_changes_nothing) {
  const rom::Network network = plates();
  for (const Eigen::Index drifting : {0, 3}) {
    Drifting watched(network, drifting);
    const EstimatorCorrection& estimator = watched.pair.estimator;
    const Eigen::MatrixXd steps = watched.bank.alternatives(watched.pair.estimator);
    ASSERT_EQ(steps.cols(), 5);
    ASSERT_EQ(steps.rows(), estimator.parameters().count());
    for (Eigen::Index s = 0; s < 4; ++s) {
      const double weight = LeaveOneOut::weight_of(watched.bank.misfit(s).evidence);
      EXPECT_TRUE(s != drifting || (weight > 0.0 && weight < 1.0)) << weight;
      const Eigen::VectorXd whole = (watched.bank.without(s).mean() - estimator.filter().mean()).head(steps.rows());
      EXPECT_LT((steps.col(s) - std::sqrt(weight) * whole).norm(), 1e-12 * whole.norm()) << s;
    }
    EXPECT_EQ(steps.col(4).norm(), 0.0);
  }
}

TEST(LeaveOneOut, the_most_doubtful_is_the_one_with_most_evidence_and_at_least_so_much) {
  const rom::Network network = plates();
  for (const Eigen::Index drifting : {0, 1, 3}) {
    Drifting watched(network, drifting);
    const double evidence = watched.bank.misfit(drifting).evidence;
    EXPECT_EQ(watched.bank.most_doubtful(-1e9), drifting);
    EXPECT_EQ(watched.bank.most_doubtful(evidence), drifting);
    EXPECT_EQ(watched.bank.most_doubtful(std::nextafter(evidence, 1e9)), -1);
    watched.bank.settle_on(drifting);
    EXPECT_EQ(watched.bank.most_doubtful(-1e9), -1) << "none is judged yet";
  }
}

TEST(LeaveOneOut, another_offset_of_a_sensor_is_that_of_each_filter_and_of_what_was_known) {
  const rom::Network network = plates();
  Watched watched(network);
  watched.run_until(1200.0);
  const EstimatorCorrection& estimator = watched.pair.estimator;
  const Eigen::Index offset = estimator.parameters().count() + 2;
  const auto means = [&] {
    std::vector<Eigen::VectorXd> all{watched.bank.before(estimator).mean()};
    for (Eigen::Index s = 0; s < 4; ++s) all.push_back(watched.bank.without(s).mean());
    return all;
  };
  const auto deviations_K = [&](Eigen::Index at) {
    std::vector<double> all{watched.bank.before(estimator).deviation(at)};
    for (Eigen::Index s = 0; s < 4; ++s) all.push_back(watched.bank.without(s).deviation(at));
    return all;
  };
  std::vector<Eigen::VectorXd> expected = means();
  const std::vector<double> sure_K = deviations_K(offset), other_K = deviations_K(offset - 1);
  watched.bank.shift_offset(estimator, 2, 0.4);
  watched.bank.widen_offset(estimator, 2, 0.3);
  for (Eigen::VectorXd& mean : expected) mean[offset] -= 0.4;
  for (std::size_t f = 0; f < expected.size(); ++f) {
    EXPECT_LT((means()[f] - expected[f]).cwiseAbs().maxCoeff(), 1e-9) << f;
    EXPECT_NEAR(deviations_K(offset)[f], std::hypot(sure_K[f], 0.3), 1e-9) << f;
    EXPECT_NEAR(deviations_K(offset - 1)[f], other_K[f], 1e-9) << f;
  }
}

TEST(LeaveOneOut, settled_on_one_filter_all_go_on_from_it_and_so_does_what_was_known) {
  const rom::Network network = plates();
  for (const Eigen::Index chosen : {0, 3}) {
    Watched watched(network);
    watched.run_until(1200.0);
    const Eigen::VectorXd mean = watched.bank.without(chosen).mean();
    watched.bank.settle_on(chosen);
    for (Eigen::Index s = 0; s < 4; ++s) {
      EXPECT_EQ(watched.bank.without(s).mean(), mean) << s;
      EXPECT_EQ(watched.bank.misfit(s).evidence, 0.0);
    }
    EXPECT_LT((watched.bank.before(watched.pair.estimator).mean() - mean).cwiseAbs().maxCoeff(), 1e-12);
  }
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
  watched.pair.estimator.adopt(watched.bank.before(watched.pair.estimator), watched.pair.operating);
  watched.bank.follow(watched.pair.estimator);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace health_leave_one_out_test
}  // namespace spindle_twin::correction::test
