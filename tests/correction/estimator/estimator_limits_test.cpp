#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace estimator_estimator_limits_test {

/// Nothing but updates, and offsets that stay where they are.
EstimatorOptions updates_alone() {
  EstimatorOptions options;
  options.second_pass = options.offset_walk_K_per_root_hour = 0.0;
  return options;
}

TEST(EstimatorUpdate, takes_a_tare_as_a_reading_of_the_offset_once) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.noise_K = 0.03;
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  const Eigen::Index offset = pair.estimator.parameters().count() + 1;
  const double shifted_K = pair.estimator.filter().mean()[offset] - 0.2;
  const double variance_K2 = std::pow(pair.estimator.filter().deviation(offset), 2.0), tare_K2 = 0.05 * 0.05;
  pair.estimator.note_tare(1, 0.2, 0.05);
  EXPECT_NEAR(pair.estimator.filter().mean()[offset], shifted_K, 1e-12);
  EXPECT_EQ(pair.estimator.record(1).offset_K, pair.estimator.filter().mean()[offset]);
  for (const double until_s : {612.0, 622.0}) {
    pair.run_until(until_s);
    EXPECT_NEAR(pair.estimator.record(1).offset_K, shifted_K * tare_K2 / (variance_K2 + tare_K2), 1e-9);
    EXPECT_NEAR(pair.estimator.record(1).offset_deviation_K, std::sqrt(variance_K2 * tare_K2 / (variance_K2 + tare_K2)),
                1e-9);
  }
}

TEST(EstimatorUpdate, of_readings_within_a_minute_each_counts_by_its_share_of_it) {
  const rom::Network network = plates();
  EstimatorOptions options = updates_alone();
  options.curvature = options.lag_deviation_s = 0.0;
  options.floor_largest_K = options.floor_K;
  Pair pair(network, options);
  const auto noise_of = [&](Eigen::Index sensor) { return pair.estimator.last_update().noise_K2[sensor]; };
  const auto one_K2 = [&](int samples) { return 0.03 * 0.03 / samples + 0.03 * 0.03; };
  pair.run_until(12.0);  // readings at 0, 2, ... 10 s
  EXPECT_NEAR(noise_of(0), one_K2(6), 1e-12) << "the first stands alone";
  pair.valid[1] = false;
  pair.run_until(32.0);
  EXPECT_NEAR(noise_of(0), 6.0 * one_K2(5), 1e-12) << "ten seconds of a minute";
  EXPECT_TRUE(std::isnan(pair.estimator.last_update().innovation_K[1]));
  pair.valid[1] = true;
  pair.run_until(42.0);
  EXPECT_NEAR(noise_of(0), 6.0 * one_K2(5), 1e-12);
  EXPECT_NEAR(noise_of(1), 2.0 * one_K2(5), 1e-12) << "thirty";
  pair.valid[1] = false;
  pair.run_until(112.0);
  pair.valid[1] = true;
  pair.run_until(122.0);
  EXPECT_NEAR(noise_of(1), one_K2(5), 1e-12) << "more than a minute";
}

TEST(EstimatorUpdate, one_reading_moves_no_ln_factor_further_than_a_straight_line_stands_for_it) {
  const rom::Network network = plates();
  EstimatorOptions options = updates_alone();
  options.gate = 1000.0;
  Pair pair(network, options);
  pair.run_until(602.0);
  pair.valid.tail(3).setConstant(false);
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K[0] += 30.0; };
  const ParameterModel& parameters = pair.estimator.parameters();
  Eigen::VectorXd before(parameters.count());
  for (Eigen::Index i = 0; i < before.size(); ++i) before[i] = pair.estimator.estimate(i).value;
  pair.run_until(612.0);
  ASSERT_TRUE(pair.estimator.record(0).fused);
  double largest = 0.0;
  for (Eigen::Index i = 0; i < before.size(); ++i) {
    if (!bends_the_state(parameters.list()[static_cast<std::size_t>(i)].kind)) continue;
    largest = std::max(largest, std::abs(pair.estimator.estimate(i).value - before[i]));
  }
  EXPECT_NEAR(largest, 0.3, 1e-6);
}

TEST(EstimatorUpdate, of_a_length_that_does_not_exist_or_is_no_number_takes_nothing) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.run_until(32.0);
  ASSERT_EQ(network.deformations.size(), 1U);
  for (const int index : {-1, 1}) {
    pair.estimator.note_displacement(index, 1e-5, 1e-6);
    pair.run_until(pair.time_s + 10.0);
    EXPECT_FALSE(std::isfinite(pair.estimator.last_update().displacement_m)) << index;
  }
  pair.estimator.note_displacement(0, std::numeric_limits<double>::infinity(), 1e-6);
  pair.run_until(pair.time_s + 10.0);
  EXPECT_FALSE(std::isfinite(pair.estimator.last_update().displacement_m));
  pair.estimator.note_displacement(0, 1e-5, 1e-6);
  pair.run_until(pair.time_s + 10.0);
  EXPECT_TRUE(std::isfinite(pair.estimator.last_update().displacement_m));
  EXPECT_EQ(pair.estimator.displacement_record().observation_K, 1e-5);
  pair.run_until(pair.time_s + 10.0);
  EXPECT_FALSE(std::isfinite(pair.estimator.last_update().displacement_m)) << "it was one update's";
}

TEST(EstimatorUpdate, a_length_far_off_opens_heats_that_no_source_explains_to_eight_and_three_times_as_far_to_thirty) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  ASSERT_FALSE(pair.estimator.heats_are_open());
  pair.estimator.note_displacement(0, pair.twin.outputs.deformations_m[0], 1e-6);
  pair.run_until(612.0);
  EXPECT_FALSE(pair.estimator.heats_are_open()) << "as it is believed";
  pair.estimator.note_displacement(0, 5e-3, 1e-6);
  pair.run_until(622.0);
  ASSERT_TRUE(pair.estimator.displacement_record().rejected);
  EXPECT_FALSE(pair.estimator.heats_are_open()) << "nobody has said the same before";
  pair.estimator.note_displacement(0, -5e-3, 1e-6);
  pair.run_until(632.0);
  EXPECT_FALSE(pair.estimator.heats_are_open()) << "nor does this one";
  pair.estimator.note_displacement(0, 5e-3, 1e-6);
  pair.run_until(642.0);
  EXPECT_FALSE(pair.estimator.heats_are_open());
  const double fading = std::exp(-10.0 / 7200.0);
  for (const double opened : {8.0, 24.0 * fading, 30.0}) {
    pair.estimator.note_displacement(0, 5e-3, 1e-6);
    pair.run_until(pair.time_s + 10.0);
    EXPECT_NEAR(pair.estimator.widths().disturbance, opened, 1e-9);
  }
}

TEST(EstimatorLoosening, without_a_reading_opens_start_and_offsets_as_far_as_the_least_that_is_believed) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.noise_K = 0.03;
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  pair.estimator.note_contradiction();
  pair.run_until(612.0);
  ASSERT_EQ(pair.estimator.loosened(), 1);
  const EstimatorCorrection& estimator = pair.estimator;
  const ParameterModel& parameters = estimator.parameters();
  for (Eigen::Index s = 0; s < 4; ++s) EXPECT_NEAR(estimator.record(s).offset_deviation_K, 0.1, 1e-9) << s;
  for (Eigen::Index i = parameters.start(); i < parameters.count(); ++i) {
    EXPECT_NEAR(estimator.estimate(i).deviation, i == parameters.start() ? 0.2 : 0.1, 1e-9) << i;
    EXPECT_EQ(estimator.estimate(i).value, 0.0) << "what it has done is in the state";
  }
  EXPECT_NEAR(estimator.widths().disturbance, 0.4, 1e-12);
  // Environments by twice of 0.2 K, which is four deviations of their prior.
  EXPECT_NEAR(estimator.widths().environment, 4.0, 1e-12);
}

TEST(EstimatorBelief, ends_three_deviations_from_the_mean_of_a_heat_a_contact_or_a_film_and_of_nothing_else) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  const ParameterModel& parameters = pair.estimator.parameters();
  EXPECT_FALSE(pair.estimator.is_beyond_belief());
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const bool counts = parameter.kind == ParameterKind::heat || parameter.kind == ParameterKind::contact ||
                        parameter.kind == ParameterKind::film;
    for (const double off : {-3.1, -2.9, 2.9, 3.1}) {
      Eigen::VectorXd theta = parameters.mean();
      theta[i] = parameter.mean + off * parameter.deviation;
      const bool at_its_end = theta[i] <= parameter.minimum || theta[i] >= parameter.maximum;
      pair.estimator.set_parameters(theta);
      EXPECT_EQ(pair.estimator.is_beyond_belief(), counts && (std::abs(off) > 3.0 || at_its_end)) << parameter.name;
    }
  }
}

TEST(EstimatorLoosening, a_change_that_health_has_found_opens_heats_to_two_deviations_and_nothing_else) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.run_until(602.0);
  pair.valid.setConstant(false);
  pair.estimator.note_change();
  pair.run_until(612.0);
  EXPECT_EQ(pair.estimator.loosened(), 0);
  EXPECT_EQ(pair.estimator.widths().disturbance, 2.0);
  const ParameterModel& parameters = pair.estimator.parameters();
  for (Eigen::Index group = 0; group < parameters.group_count(); ++group) {
    const int slot = parameters.disturbance(group);
    const double deviation_W = parameters.list()[static_cast<std::size_t>(slot)].deviation;
    EXPECT_NEAR(pair.estimator.estimate(slot).deviation, 2.0 * deviation_W, 1e-6 * deviation_W);
    EXPECT_EQ(pair.estimator.open_heat_W(group), 2.0 * deviation_W);
  }
  pair.run_until(622.0);
  EXPECT_NEAR(pair.estimator.widths().disturbance, 2.0 * std::exp(-10.0 / 7200.0), 1e-12) << "it was told once";
}

TEST(EstimatorMemory, of_which_any_part_has_another_size_or_a_number_that_is_none_is_refused_and_nothing_taken) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.run_until(302.0);
  EstimatorState good;
  pair.estimator.save(good);
  EstimatorCorrection other(network, updates_alone());
  other.reset(pair.time_s, pair.twin.stepper.temperatures_K(), pair.operating);
  const Eigen::VectorXd mean = other.filter().mean();
  for (const auto member :
       {&EstimatorState::mean, &EstimatorState::root, &EstimatorState::sensitivities, &EstimatorState::lagged,
        &EstimatorState::channels, &EstimatorState::start, &EstimatorState::scale}) {
    EstimatorState bad = good;
    (bad.*member).push_back(0.0);
    EXPECT_FALSE(other.restore(bad));
    bad = good;
    (bad.*member).back() = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(other.restore(bad));
  }
  EXPECT_EQ(other.filter().mean(), mean);
  EXPECT_TRUE(other.restore(good));
  EXPECT_EQ(other.filter().mean(), pair.estimator.filter().mean());
}

TEST(EstimatorMemory, tells_of_a_machine_only_where_all_of_its_numbers_are_there) {
  const rom::Network network = plates();
  Pair pair(network, updates_alone());
  pair.run_until(32.0);
  EstimatorState good;
  pair.estimator.save(good);
  const std::vector<std::string> names = pair.estimator.unknowns();
  ASSERT_TRUE(known_from(names, good).has_value());
  EXPECT_LT((known_from(names, good)->covariance - pair.estimator.covariance()).norm(),
            1e-12 * pair.estimator.covariance().norm());
  EXPECT_FALSE(known_from({}, EstimatorState{}).has_value());
  EXPECT_FALSE(known_from({names.begin() + 1, names.end()}, good).has_value());
  for (const auto member :
       {&EstimatorState::mean, &EstimatorState::root, &EstimatorState::scale, &EstimatorState::nominal}) {
    EstimatorState bad = good;
    (bad.*member).pop_back();
    EXPECT_FALSE(known_from(names, bad).has_value());
    bad = good;
    (bad.*member).front() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(known_from(names, bad).has_value());
  }
}

}  // namespace estimator_estimator_limits_test
}  // namespace spindle_twin::correction::test
