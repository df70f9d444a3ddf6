#include "correction/estimator/second_pass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace second_pass_test {

EstimatorOptions gone_through(double times) {
  EstimatorOptions options;
  options.second_pass = times;
  return options;
}

/// A spindle whose heats and contacts lie far out in their priors, for each of which the filter's first steps are long.
struct FarOut : Pair {
  FarOut(const rom::Network& the_network, const EstimatorOptions& options) : Pair(the_network, options) {
    truth = estimator.parameters().mean();
    for (Eigen::Index i = 0; i < truth.size(); ++i) {
      const ParameterKind kind = estimator.parameters().list()[static_cast<std::size_t>(i)].kind;
      if (kind == ParameterKind::heat) truth[i] += 1.3;
      if (kind == ParameterKind::contact) truth[i] -= 1.5;
    }
  }
  /// Root of the mean squared error of the ln factors, in deviations that the estimate claims.
  double off_by() const {
    double sum = 0.0;
    int count = 0;
    for (Eigen::Index i = 0; i < truth.size(); ++i) {
      const ParameterKind kind = estimator.parameters().list()[static_cast<std::size_t>(i)].kind;
      if (kind != ParameterKind::heat && kind != ParameterKind::contact) continue;
      const ParameterEstimate found = estimator.estimate(i);
      sum += std::pow((found.value - truth[i]) / found.deviation, 2.0);
      ++count;
    }
    return std::sqrt(sum / count);
  }
};

TEST(SecondPass, what_the_first_minutes_took_for_a_straight_line_is_put_right) {
  const rom::Network network = plates();
  FarOut without(network, gone_through(0.0)), with(network, gone_through(20.0));
  without.run_until(2400.0);
  with.run_until(2400.0);
  EXPECT_GE(with.estimator.relinearised(), 1);
  EXPECT_LT(with.off_by(), 0.7 * without.off_by());
  EXPECT_LT(with.off_by(), 1.5);
}

TEST(SecondPass, of_a_linear_model_comes_to_what_the_updates_have_come_to) {
  const rom::Network network = plates();
  EstimatorOptions options = environments_alone();
  options.period_s = 2.0;
  EstimatorOptions alone = options;
  alone.second_pass = 0.0;
  Pair with(network, options), without(network, alone);
  for (Pair* pair : {&with, &without}) {
    pair->truth << 0.4, -0.3;
    pair->noise_K = 0.02;
    pair->run_until(2200.0);
  }
  ASSERT_EQ(with.estimator.relinearised(), 1);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const ParameterEstimate found = with.estimator.estimate(i), other = without.estimator.estimate(i);
    EXPECT_NEAR(found.value, other.value, 0.1 * other.deviation) << i;
    EXPECT_NEAR(found.deviation, other.deviation, 0.02 * other.deviation) << i;
  }
}

TEST(SecondPass, leaves_the_estimate_where_no_constant_heat_fits_the_readings) {
  const rom::Network network = plates();
  Pair with(network, gone_through(20.0)), without(network, gone_through(0.0));
  for (Pair* pair : {&with, &without}) {
    pair->truth = pair->estimator.parameters().mean();
    const double mean = pair->truth[0];
    while (pair->time_s < 2400.0) {
      pair->truth[0] = mean + 0.15 * std::sin(pair->time_s / 300.0);
      pair->cycle();
    }
    EXPECT_EQ(pair->estimator.loosened(), 0) << "the record is whole";
  }
  EXPECT_EQ(with.estimator.relinearised(), 0);
  EXPECT_EQ(with.nose_error_m(), without.nose_error_m());
}

TEST(SecondPass, the_same_history_gives_the_same_bits) {
  const rom::Network network = plates();
  FarOut one(network, {}), other(network, {});
  one.run_until(2200.0);
  other.run_until(2200.0);
  EXPECT_GE(one.estimator.relinearised(), 1);
  EXPECT_EQ(one.estimator.filter().mean(), other.estimator.filter().mean());
}

TEST(SecondPass, knows_nothing_of_a_start_before) {
  const rom::Network network = plates();
  FarOut fresh(network, {}), used(network, {});
  const Eigen::VectorXd cold_K = fresh.twin.stepper.temperatures_K();
  used.run_until(800.0);
  used.estimator.reset(0.0, cold_K, used.operating);
  used.time_s = 0.0;
  for (Model* model : {&used.plant, &used.twin}) {
    model->stepper.set_temperatures(cold_K);
    rom::evaluate_outputs(network, cold_K, model->outputs, 1.0);
  }
  const long before = used.estimator.relinearised();
  fresh.run_until(2200.0);
  used.run_until(2200.0);
  EXPECT_GE(fresh.estimator.relinearised(), 1);
  EXPECT_EQ(used.estimator.relinearised() - before, fresh.estimator.relinearised());
  // CVODE keeps a Newton matrix from before, so not to the bit.
  EXPECT_LT((fresh.estimator.filter().mean() - used.estimator.filter().mean()).norm(), 1e-3);
}

TEST(SecondPass, a_cycle_after_a_pause_goes_through_no_more_of_the_record_than_others) {
  const rom::Network network = plates();
  Pair pair(network, gone_through(20.0));
  pair.truth = pair.estimator.parameters().mean();  // settles in one pass
  pair.run_until(1802.0);                           // which has begun
  pair.cycle_s = 300.0;
  pair.cycle();
  pair.cycle_s = 2.0;
  pair.cycle();  // after 300 s, in which 20 times as much could have been gone through
  EXPECT_EQ(pair.estimator.relinearised(), 0);
  pair.run_until(2400.0);
  EXPECT_EQ(pair.estimator.relinearised(), 1);
}

/// 200 s of the record in each cycle of 10 s in which a thousand could be: half an hour and what comes meanwhile in
/// ten.
TEST(SecondPass, no_cycle_goes_through_more_than_200_s_of_the_record) {
  const rom::Network network = rom::tests::make_single_node();
  EstimatorOptions options = environments_alone();
  options.second_pass = 100.0;
  Pair pair(network, options);
  pair.cycle_s = 10.0;
  while (pair.estimator.relinearised() == 0 && pair.time_s < 2400.0) pair.cycle();
  EXPECT_EQ(pair.time_s - pair.cycle_s, 1800.0 + 100.0);
}

/// A linear estimate settles in one pass, at twenty times the speed of what was recorded.
TEST(SecondPass, is_made_after_half_an_hour_an_hour_and_two_of_the_record_and_no_more) {
  const rom::Network network = rom::tests::make_single_node();
  Pair pair(network, environments_alone());
  pair.cycle_s = 10.0;
  std::vector<double> ages_s;
  while (pair.time_s < 16000.0) {
    const long before = pair.estimator.relinearised();
    pair.cycle();
    if (pair.estimator.relinearised() > before) ages_s.push_back(pair.time_s - pair.cycle_s);
  }
  ASSERT_EQ(ages_s.size(), 3U);
  const double expected_s[] = {1800.0, 3600.0, 7200.0};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GE(ages_s[k], expected_s[k] + expected_s[k] / 20.0);
    EXPECT_LE(ages_s[k], expected_s[k] * 20.0 / 19.0 + 30.0);
  }
}

TEST(SecondPass, an_estimate_that_begins_anew_begins_another_record) {
  const rom::Network network = plates();
  Pair pair(network, {});
  pair.truth = pair.estimator.parameters().mean();
  pair.run_until(500.0);
  pair.estimator.note_contradiction();
  pair.run_until(2250.0);
  EXPECT_EQ(pair.estimator.loosened(), 1);
  EXPECT_EQ(pair.estimator.relinearised(), 0) << "half an hour is not over since";
  pair.run_until(2800.0);
  EXPECT_GE(pair.estimator.relinearised(), 1);
}

TEST(SecondPass, takes_lengths_in_where_they_were_told) {
  const rom::Network network = plates();
  FarOut pair(network, {});
  pair.run_until(400.0);
  pair.estimator.note_displacement(0, pair.plant.outputs.deformations_m[0], 1e-7);
  pair.run_until(1798.0);
  const double known_m = pair.estimator.deviations().deformations_m[0];
  pair.run_until(2200.0);
  ASSERT_GE(pair.estimator.relinearised(), 1);
  EXPECT_LT(pair.estimator.deviations().deformations_m[0], 2.0 * known_m) << "without the length it is open again";
  EXPECT_LT(std::abs(pair.nose_error_m()), 2.0 * pair.estimator.deviations().deformations_m[0]);
}

TEST(ReadingRecord, holds_means_over_two_seconds_at_the_most_and_ends_where_inputs_change) {
  const rom::Network network = plates();
  rom::OperatingState operating = network.boundaries.operating;
  ReadingRecord record(network.boundaries, 2, 3);
  record.begin(10.0, operating);
  Eigen::Array<bool, Eigen::Dynamic, 1> valid(2);
  valid << true, true;
  const auto reading = [](double first, double second) { return Eigen::VectorXd(Eigen::Vector2d(first, second)); };
  EXPECT_TRUE(record.note(11.0, reading(300.0, 310.0), valid, operating, false));
  valid[1] = false;
  EXPECT_EQ(record.count(), 0U);
  EXPECT_TRUE(record.note(12.0, reading(302.0, 999.0), valid, operating, false));
  ASSERT_EQ(record.count(), 1U);
  EXPECT_EQ(record.at(0).begin_s, 10.0);
  EXPECT_EQ(record.at(0).end_s, 12.0);
  EXPECT_EQ(record.at(0).reading_K, reading(301.0, 310.0));
  EXPECT_EQ(record.at(0).length.index, -1);
  record.note_displacement({0, 1e-5, 1e-6});
  const double before_rpm = operating.speed_rpm;
  operating.speed_rpm *= 2.0;
  EXPECT_TRUE(record.note(13.0, reading(std::numeric_limits<double>::quiet_NaN(), 1.0), valid, operating, false));
  ASSERT_EQ(record.count(), 2U);
  EXPECT_EQ(record.at(1).operating.speed_rpm, before_rpm) << "of what was held until then";
  EXPECT_TRUE(record.at(1).reading_K.array().isNaN().all());
  EXPECT_EQ(record.at(1).length.value_m, 1e-5);
  EXPECT_TRUE(record.note(13.5, reading(300.0, 1.0), valid, operating, true)) << "an update ends it too";
  EXPECT_EQ(record.at(2).operating.speed_rpm, operating.speed_rpm);
  EXPECT_EQ(record.at(2).length.index, -1);
  EXPECT_FALSE(record.note(14.0, reading(300.0, 1.0), valid, operating, true)) << "full";
  record.begin(20.0, operating);
  EXPECT_EQ(record.count(), 0U);
}

}  // namespace second_pass_test
}  // namespace spindle_twin::correction::test
