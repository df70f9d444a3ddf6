#include "correction/health/second_opinion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "correction/health/surprise.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace health_second_opinion_test {

constexpr double blamed_s = 3600.0;

/// Plant and twin at changing speed; after an hour one sensor is blamed, and the estimate loosened for it.
struct Blamed {
  explicit Blamed(const rom::Network& network) : pair(network, {}), bank(pair.estimator), opinion(pair.estimator) {
    pair.noise_K = 0.03;
    pair.truth[0] = 0.3;
  }
  /// Gives what is concluded by end_s, as soon as it is.
  Opinion run_until(double end_s) {
    while (pair.time_s < end_s) {
      pair.operating.speed_rpm = std::fmod(pair.time_s, 1800.0) < 900.0 ? 6000.0 : 1500.0;
      pair.cycle();
      if (pair.estimator.updates() == updates) continue;
      updates = pair.estimator.updates();
      bank.update(pair.estimator);
      opinion.update(pair.estimator);
      if (opinion.conclude(false, limits) != Opinion::pending) break;
    }
    return opinion.conclude(false, limits);
  }
  void blame(Eigen::Index sensor) {
    opinion.begin(sensor, bank);
    pair.estimator.note_contradiction();
  }
  Pair pair;
  LeaveOneOut bank;
  SecondOpinion opinion;
  HealthLimits limits;
  long updates = 0;
};

TEST(SecondOpinion, of_a_sensor_that_drifts_it_is_that_it_has_failed_and_what_it_kept_has_not_followed) {
  const rom::Network network = plates();
  for (Eigen::Index drifting = 0; drifting < 4; ++drifting) {
    Blamed blamed(network);
    blamed.pair.tamper = [&](Eigen::VectorXd& readings_K) {
      readings_K[drifting] += 10.0 / 3600.0 * std::max(0.0, blamed.pair.time_s - blamed_s + 300.0);
    };
    ASSERT_EQ(blamed.run_until(blamed_s), Opinion::pending) << "nothing is pending";
    blamed.blame(drifting);
    EXPECT_EQ(blamed.run_until(blamed_s + 7200.0), Opinion::against_sensor) << drifting;
    EXPECT_GT(blamed.pair.time_s, blamed_s + blamed.limits.opinion_least_s);
    const double drifted_K = 10.0 / 3600.0 * (blamed.pair.time_s - blamed_s + 300.0);
    EXPECT_NEAR(blamed.opinion.misfit().misfit_K, drifted_K, 3.0 * blamed.opinion.misfit().deviation_K) << drifting;
    EstimatorCorrection& estimator = blamed.pair.estimator;
    const double followed_m = std::abs(blamed.pair.nose_error_m());
    estimator.adopt(blamed.opinion.filter(), blamed.pair.operating);
    blamed.pair.twin.stepper.set_temperatures(estimator.corrected_nodes_K());
    rom::evaluate_outputs(network, estimator.corrected_nodes_K(), blamed.pair.twin.outputs,
                          estimator.factors().expansion);
    EXPECT_LT(std::abs(blamed.pair.nose_error_m()), 2.0 * estimator.deviations().deformations_m[0]) << drifting;
    EXPECT_LT(std::abs(blamed.pair.nose_error_m()), std::max(followed_m, 2e-7)) << drifting;
  }
}

TEST(SecondOpinion, where_the_spindle_changes_the_others_contradict_it_whichever_sensor_was_blamed) {
  const rom::Network network = plates();
  for (Eigen::Index healthy = 0; healthy < 4; ++healthy) {
    Blamed blamed(network);
    blamed.run_until(blamed_s - 300.0);
    blamed.pair.truth[0] = -0.7;  // friction is a third of what it was
    blamed.run_until(blamed_s);
    blamed.blame(healthy);
    EXPECT_EQ(blamed.run_until(blamed_s + 7200.0), Opinion::against_model) << healthy;
  }
}

TEST(SecondOpinion, evidence_is_what_an_update_surprises_the_estimator_less_what_it_surprises_the_kept_and_fades) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.run_until(blamed_s);
  const EstimatorCorrection& estimator = blamed.pair.estimator;
  const Widths closed = estimator.widths();
  blamed.blame(1);
  blamed.run_until(blamed_s + 122.0);
  ASSERT_GT(estimator.widths().environment, closed.environment);
  const double before = blamed.opinion.misfit().evidence;
  SquareRootFilter kept = blamed.opinion.filter();
  blamed.run_until(blamed_s + 132.0);
  const EstimatorUpdate& made = estimator.last_update();
  ASSERT_EQ(made.elapsed_s, 10.0);
  // The kept filter passes time as the estimator did before it was loosened.
  Eigen::VectorXd keep(made.unknowns.size()), growth(made.unknowns.size());
  estimator.passing_of_time(made.elapsed_s, closed, keep, growth);
  kept.pass_time(estimator.prior().mean(), keep, growth);
  double gained = 0.0;
  for (Eigen::Index s = 0; s < 4; ++s) {
    gained += std::pow(estimator.record(s).innovation_K, 2) / estimator.record(s).variance_K2;
    if (s == 1) continue;
    const Eigen::VectorXd row = made.rows.col(s);
    const double innovation_K = made.innovation_at(s, kept.mean()), variance_K2 = kept.variance_of(row);
    gained -= innovation_K * innovation_K / (variance_K2 + made.noise_K2[s]);
    kept.update(row, innovation_K, made.noise_K2[s]);
  }
  EXPECT_NEAR(blamed.opinion.misfit().evidence, std::exp(-10.0 / evidence_memory_s) * before + gained, 1e-9);
}

TEST(SecondOpinion, while_it_is_pending_what_is_published_has_room_for_it_where_the_blame_had_evidence) {
  const rom::Network network = plates();
  for (const double rate_K_per_h : {0.0, 10.0}) {
    Blamed blamed(network);
    blamed.pair.tamper = [&](Eigen::VectorXd& readings_K) {
      readings_K[2] += rate_K_per_h / 3600.0 * std::max(0.0, blamed.pair.time_s - blamed_s + 600.0);
    };
    blamed.run_until(blamed_s);
    const EstimatorCorrection& estimator = blamed.pair.estimator;
    Eigen::MatrixXd steps = blamed.bank.alternatives(estimator);
    const Eigen::MatrixXd of_bank = steps;
    blamed.opinion.put_alternative(estimator, steps);
    EXPECT_EQ((steps - of_bank).norm(), 0.0) << "nobody was blamed";
    const double evidence = blamed.bank.misfit(2).evidence;
    blamed.blame(2);
    blamed.run_until(blamed_s + 60.0);
    const double since = blamed.opinion.misfit().evidence;
    ASSERT_GT(since, -4.0);
    const double weight = LeaveOneOut::weight_of(evidence + since);
    EXPECT_EQ(weight, rate_K_per_h > 0.0 ? 1.0 : 0.0) << evidence << " and " << since;
    blamed.opinion.put_alternative(estimator, steps);
    const Eigen::VectorXd whole =
        (blamed.opinion.filter().mean() - estimator.filter().mean()).head(estimator.parameters().count());
    EXPECT_GT(whole.norm(), 0.0);
    EXPECT_EQ((steps.col(4) - weight * whole).norm(), 0.0);
    EXPECT_EQ((steps - of_bank).leftCols(4).norm(), 0.0) << "what the bank says of the sensor stays beside it";
    EXPECT_EQ(blamed.bank.alternatives(estimator).col(4).norm(), 0.0);
  }
}

TEST(SecondOpinion, readings_that_contradict_a_second_time_decide_where_it_fits_as_well) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.pair.tamper = [&](Eigen::VectorXd& readings_K) {
    readings_K[3] += 5.0 / 3600.0 * std::max(0.0, blamed.pair.time_s - blamed_s + 600.0);
  };
  blamed.run_until(blamed_s);
  blamed.blame(3);
  while (blamed.pair.time_s < blamed_s + 7200.0) {
    const Opinion opinion = blamed.run_until(blamed.pair.time_s + 10.0);
    const double age_s = blamed.pair.time_s - blamed_s, evidence = blamed.opinion.misfit().evidence;
    const bool old = age_s > blamed.limits.opinion_least_s + 12.0;
    if (age_s < blamed.limits.opinion_least_s - 12.0) {
      EXPECT_EQ(blamed.opinion.conclude(true, blamed.limits), Opinion::pending);
    } else if (old) {
      EXPECT_EQ(blamed.opinion.conclude(true, blamed.limits) == Opinion::against_sensor, evidence > 0.0) << evidence;
      EXPECT_EQ(opinion == Opinion::against_sensor, evidence > blamed.limits.drift_lead) << evidence;
    }
    if (opinion != Opinion::pending) break;
  }
  EXPECT_EQ(blamed.opinion.conclude(false, blamed.limits), Opinion::against_sensor);
  blamed.opinion.drop();
  EXPECT_EQ(blamed.opinion.conclude(true, blamed.limits), Opinion::pending);
}

TEST(SecondOpinion, what_the_start_has_done_until_the_loosening_is_in_the_state_and_counts_once) {
  const rom::Network network = plates();
  Blamed blamed(network);
  const Eigen::VectorXd warm_K = (blamed.pair.plant.stepper.temperatures_K().array() + 0.6).matrix();
  blamed.pair.plant.stepper.set_temperatures(warm_K);
  blamed.run_until(300.0);
  const ParameterModel& parameters = blamed.pair.estimator.parameters();
  const auto largest_K = [&](const SquareRootFilter& filter) {
    return filter.mean().segment(parameters.count() - parameters.starts(), parameters.starts()).cwiseAbs().maxCoeff();
  };
  const double known_K = largest_K(blamed.bank.without(1));
  ASSERT_EQ(blamed.pair.estimator.loosened(), 0);
  ASSERT_GT(known_K, 0.2) << "the spindle was 0.6 K warmer than the twin believed";
  blamed.blame(1);
  EXPECT_EQ(largest_K(blamed.opinion.filter()), known_K);
  blamed.run_until(322.0);
  ASSERT_EQ(blamed.pair.estimator.loosened(), 1);
  EXPECT_LT(largest_K(blamed.opinion.filter()), 0.3 * known_K);
}

/// The kept filter after an update, from what it was before: as the header says, with what came in of all but sensor 1.
SquareRootFilter gone_on(SquareRootFilter kept, const EstimatorCorrection& estimator, const Widths& widths) {
  const EstimatorUpdate& made = estimator.last_update();
  Eigen::VectorXd keep(made.unknowns.size()), growth(made.unknowns.size());
  estimator.passing_of_time(made.elapsed_s, widths, keep, growth);
  kept.pass_time(estimator.prior().mean(), keep, growth);
  for (Eigen::Index s = 0; s < 4; ++s) {
    if (s != 1) kept.update(made.rows.col(s), made.innovation_at(s, kept.mean()), made.noise_K2[s]);
  }
  Eigen::VectorXd within = kept.mean();
  estimator.bound(within);
  kept.set_mean(within);
  return kept;
}

TEST(SecondOpinion, that_begins_without_a_loosening_takes_the_start_that_was_found_until_then_once) {
  const rom::Network network = plates();
  Blamed blamed(network);
  const EstimatorCorrection& estimator = blamed.pair.estimator;
  const Eigen::Index starts = estimator.parameters().starts(), first = estimator.parameters().count() - starts;
  ASSERT_GT(starts, 0);
  const Eigen::VectorXd warm_K = (blamed.pair.plant.stepper.temperatures_K().array() + 0.6).matrix();
  blamed.pair.plant.stepper.set_temperatures(warm_K);
  blamed.pair.offset_K[1] = 0.3;  // what the sensor says of the start is not what the others say
  blamed.run_until(302.0);
  blamed.opinion.begin(1, blamed.bank);
  const Widths widths = estimator.widths();
  SquareRootFilter expected = blamed.opinion.filter();
  for (const double end_s : {312.0, 322.0}) {
    blamed.run_until(end_s);
    const EstimatorUpdate& made = estimator.last_update();
    ASSERT_EQ(estimator.loosened(), 0);
    Eigen::VectorXd mean = expected.mean();
    const Eigen::VectorXd found_K = made.unknowns.segment(first, starts);
    EXPECT_GT((found_K - mean.segment(first, starts)).cwiseAbs().maxCoeff(), 1e-3) << "the same either way";
    if (end_s < 320.0) mean.segment(first, starts) = found_K;
    expected.set_mean(mean);
    expected = gone_on(expected, estimator, widths);
    EXPECT_LT((blamed.opinion.filter().mean() - expected.mean()).cwiseAbs().maxCoeff(), 1e-9) << "at " << end_s << " s";
  }
}

TEST(SecondOpinion, another_that_begins_forgets_the_age_and_the_evidence_of_the_one_before) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.run_until(blamed_s);
  blamed.blame(1);
  blamed.run_until(blamed_s + 322.0);
  ASSERT_NE(blamed.opinion.misfit().evidence, 0.0);
  HealthLimits limits = blamed.limits;
  limits.second_opinion_s = 100.0;
  EXPECT_EQ(blamed.opinion.conclude(false, limits), Opinion::undecided);
  blamed.opinion.begin(2, blamed.bank);
  EXPECT_EQ(blamed.opinion.sensor(), 2);
  EXPECT_EQ(blamed.opinion.misfit().evidence, 0.0);
  EXPECT_EQ(blamed.opinion.conclude(false, limits), Opinion::pending);
  EXPECT_EQ((blamed.opinion.filter().mean() - blamed.bank.without(2).mean()).norm(), 0.0);
}

TEST(SecondOpinion, its_limits_of_age_and_evidence_are_not_yet_passed_where_they_are_met) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.limits.drift_lead = blamed.limits.second_opinion_s = 1e9;  // it is asked here
  blamed.pair.tamper = [&](Eigen::VectorXd& readings_K) {
    readings_K[3] += 10.0 / 3600.0 * std::max(0.0, blamed.pair.time_s - blamed_s + 600.0);
  };
  blamed.run_until(blamed_s + 2.0);  // with an update in the cycle before
  blamed.blame(3);
  double end_s = blamed_s + 2.0;
  while (blamed.opinion.misfit().evidence < 0.5 && end_s < blamed_s + 3600.0) blamed.run_until(end_s += 10.0);
  const double evidence = blamed.opinion.misfit().evidence, age_s = end_s - blamed_s - 2.0;
  ASSERT_GT(evidence, 0.5);
  const auto concluded = [&](double least_s, double most_s, double lead, bool again) {
    HealthLimits limits;
    limits.opinion_least_s = least_s;
    limits.second_opinion_s = most_s;
    limits.drift_lead = lead;
    return blamed.opinion.conclude(again, limits);
  };
  EXPECT_EQ(concluded(age_s - 1.0, age_s, 0.5 * evidence, false), Opinion::against_sensor);
  EXPECT_EQ(concluded(age_s, age_s, 0.5 * evidence, false), Opinion::pending);
  EXPECT_EQ(concluded(age_s - 1.0, age_s, evidence, false), Opinion::pending);
  EXPECT_EQ(concluded(age_s - 1.0, age_s, 2.0 * evidence, true), Opinion::against_sensor) << "again: above zero";
  EXPECT_EQ(concluded(age_s - 2.0, age_s - 1.0, 0.5 * evidence, false), Opinion::undecided);
}

TEST(SecondOpinion, as_the_others_contradict_it_what_is_published_narrows_until_it_is_against_the_model) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.run_until(blamed_s - 300.0);
  blamed.pair.truth[0] = -0.7;
  blamed.run_until(blamed_s);
  Eigen::Index blamed_first = 0;
  for (Eigen::Index s = 1; s < 4; ++s) {
    if (blamed.bank.misfit(s).evidence > blamed.bank.misfit(blamed_first).evidence) blamed_first = s;
  }
  const double begun_with = blamed.bank.misfit(blamed_first).evidence;
  blamed.blame(blamed_first);
  const EstimatorCorrection& estimator = blamed.pair.estimator;
  Opinion opinion = Opinion::pending;
  int between = 0;
  while (opinion == Opinion::pending && blamed.pair.time_s < blamed_s + 7200.0) {
    opinion = blamed.run_until(blamed.pair.time_s + 2.0);
    const double evidence = blamed.opinion.misfit().evidence;
    EXPECT_EQ(opinion == Opinion::against_model, evidence < -12.0) << evidence;
    const double since = std::clamp((evidence + 12.0) / 8.0, 0.0, 1.0);
    const double weight = std::min(since, LeaveOneOut::weight_of(begun_with + evidence));
    between += since > 0.0 && since < 1.0 && since < LeaveOneOut::weight_of(begun_with + evidence) ? 1 : 0;
    Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(estimator.parameters().count(), 5);
    blamed.opinion.put_alternative(estimator, steps);
    const Eigen::VectorXd whole = (blamed.opinion.filter().mean() - estimator.filter().mean()).head(steps.rows());
    EXPECT_LT((steps.col(4) - std::sqrt(weight) * whole).norm(), 1e-9 * whole.norm()) << evidence;
  }
  EXPECT_EQ(opinion, Opinion::against_model);
  EXPECT_GT(between, 3) << "begun with evidence of " << begun_with;
}

TEST(SecondOpinion, what_is_published_has_room_for_it_by_the_evidence_of_the_beginning_and_what_has_come_since) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.limits.drift_lead = blamed.limits.second_opinion_s = 1e9;  // it goes on
  blamed.pair.tamper = [&](Eigen::VectorXd& readings_K) {
    readings_K[3] += 10.0 / 3600.0 * std::max(0.0, blamed.pair.time_s - blamed_s + 600.0);
  };
  double end_s = blamed_s - 600.0;
  const auto begun_with = [&] { return blamed.bank.misfit(3).evidence; };
  while ((LeaveOneOut::weight_of(begun_with()) <= 0.0 || blamed.pair.time_s < blamed_s - 500.0) && end_s < blamed_s) {
    blamed.run_until(end_s += 10.0);
  }
  const double begun = begun_with();
  ASSERT_GT(LeaveOneOut::weight_of(begun), 0.0);
  ASSERT_LT(LeaveOneOut::weight_of(begun), 1.0) << begun;
  blamed.opinion.begin(3, blamed.bank);
  const EstimatorCorrection& estimator = blamed.pair.estimator;
  int between = 0;
  for (const double until_s = end_s + 900.0; end_s < until_s;) {
    blamed.run_until(end_s += 10.0);
    const double evidence = blamed.opinion.misfit().evidence;
    const double since = std::clamp((evidence + 12.0) / 8.0, 0.0, 1.0);
    const double weight = std::min(since, LeaveOneOut::weight_of(begun + evidence));
    between += weight < 1.0 && std::abs(weight - LeaveOneOut::weight_of(begun - evidence)) > 1e-3 ? 1 : 0;
    Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(estimator.parameters().count(), 5);
    blamed.opinion.put_alternative(estimator, steps);
    const Eigen::VectorXd whole = (blamed.opinion.filter().mean() - estimator.filter().mean()).head(steps.rows());
    EXPECT_LT((steps.col(4) - std::sqrt(weight) * whole).norm(), 1e-9 * whole.norm()) << evidence;
  }
  EXPECT_GT(between, 1) << "begun with " << begun;
}

TEST(SecondOpinion, a_tare_or_another_offset_is_the_kept_filters_too) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.run_until(blamed_s);
  blamed.blame(1);
  const Eigen::Index offset = blamed.pair.estimator.parameters().count() + 2;
  const double before_K = blamed.opinion.filter().mean()[offset];
  const double deviation_K = blamed.opinion.filter().deviation(offset);
  blamed.opinion.shift_offset(blamed.pair.estimator, 2, 0.4);
  blamed.opinion.widen_offset(blamed.pair.estimator, 2, 0.3);
  EXPECT_DOUBLE_EQ(blamed.opinion.filter().mean()[offset], before_K - 0.4);
  EXPECT_NEAR(blamed.opinion.filter().deviation(offset), std::hypot(deviation_K, 0.3), 1e-12);
}

TEST(SecondOpinion, nothing_calls_the_heap) {
  const rom::Network network = plates();
  Blamed blamed(network);
  blamed.run_until(60.0);
  Eigen::MatrixXd& steps = blamed.bank.alternatives(blamed.pair.estimator);
  const long before = rom::tests::heap_calls();
  blamed.opinion.begin(1, blamed.bank);
  blamed.opinion.update(blamed.pair.estimator);
  blamed.opinion.put_alternative(blamed.pair.estimator, steps);
  blamed.opinion.widen_offset(blamed.pair.estimator, 1, 0.2);
  blamed.opinion.shift_offset(blamed.pair.estimator, 1, 0.2);
  blamed.pair.estimator.adopt(blamed.opinion.filter(), blamed.pair.operating);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace health_second_opinion_test
}  // namespace spindle_twin::correction::test
