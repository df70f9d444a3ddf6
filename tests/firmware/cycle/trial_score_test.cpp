#include "firmware/cycle/trial_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace spindle_twin::firmware {
namespace cycle_trial_score_test {

// Numbers that a double holds, so that a limit can be met to the bit.
constexpr ExchangePlan judged{0.0, 0.0, 0.25, 0.5};
constexpr double reading_K = 300.0;

/// How far off one twin foretells each of two sensors.
struct Errors {
  std::vector<double> corrected_K, uncorrected_K;
};

/// Both read the same; what each said for now, it says for the next cycle too.
Snapshot that_errs(const Errors& by) {
  Snapshot snapshot;
  snapshot.key_points = by.corrected_K.size();
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    snapshot.sensor_quality[k] = SensorQuality::good;
    snapshot.measured_K[k] = reading_K;
    snapshot.predicted_K[k] = reading_K - by.corrected_K[k];
    snapshot.uncorrected_K[k] = reading_K - by.uncorrected_K[k];
  }
  return snapshot;
}

Snapshot that_errs(const std::vector<double>& by_K) { return that_errs({by_K, by_K}); }

/// After so many cycles that count.
TrialScore score_of(const Errors& running, const Errors& beside, int cycles = 1) {
  TrialScore score;
  for (int n = 0; n < cycles + 1; ++n) score.add(that_errs(running), that_errs(beside));
  return score;
}

TrialScore score_of(const std::vector<double>& running_K, const std::vector<double>& beside_K, int cycles = 1) {
  return score_of(Errors{running_K, running_K}, Errors{beside_K, beside_K}, cycles);
}

TEST(TrialScore, a_prediction_is_compared_with_the_reading_of_the_cycle_after_it) {
  TrialScore score;
  Snapshot running = that_errs({0.0}), beside = that_errs({0.0});
  running.predicted_K[0] = 290.0;
  beside.predicted_K[0] = 297.0;
  EXPECT_FALSE(score.add(running, beside)) << "nothing was foretold for now";
  EXPECT_TRUE(std::isnan(score.running_K()));
  EXPECT_TRUE(std::isnan(score.beside_K()));
  running.measured_K[0] = beside.measured_K[0] = 302.0;
  running.predicted_K[0] = beside.predicted_K[0] = 302.0;  // for later
  EXPECT_TRUE(score.add(running, beside));
  EXPECT_EQ(score.running_K(), 12.0);
  EXPECT_EQ(score.beside_K(), 5.0);
}

TEST(TrialScore, is_the_root_of_the_mean_square_over_sensors_and_cycles) {
  EXPECT_DOUBLE_EQ(score_of({3.0}, {-7.0}).running_K(), 3.0);
  EXPECT_DOUBLE_EQ(score_of({3.0}, {-7.0}).beside_K(), 7.0);
  for (const int cycles : {1, 2, 9}) {
    const TrialScore score = score_of({3.0, -4.0}, {1.0, 7.0}, cycles);
    EXPECT_DOUBLE_EQ(score.running_K(), std::sqrt((9.0 + 16.0) / 2.0)) << cycles;
    EXPECT_DOUBLE_EQ(score.beside_K(), std::sqrt((1.0 + 49.0) / 2.0)) << cycles;
  }
}

TEST(TrialScore, a_sensor_counts_where_one_of_both_believes_it) {
  for (const bool by_running : {false, true}) {
    for (const bool by_beside : {false, true}) {
      TrialScore score;
      Snapshot running = that_errs({2.0}), beside = that_errs({6.0});
      if (!by_running) running.sensor_quality[0] = SensorQuality::withheld;
      if (!by_beside) beside.sensor_quality[0] = SensorQuality::withheld;
      score.add(running, beside);
      EXPECT_EQ(score.add(running, beside), by_running || by_beside);
      EXPECT_EQ(std::isnan(score.running_K()), !by_running && !by_beside);
    }
  }
}

TEST(TrialScore, one_sensor_that_is_compared_is_enough_whichever_it_is) {
  for (const std::size_t lost : {0U, 1U}) {
    TrialScore score;
    Snapshot running = that_errs({2.0, 2.0}), beside = that_errs({6.0, 6.0});
    for (Snapshot* each : {&running, &beside}) each->sensor_quality[lost] = SensorQuality::stale;
    score.add(running, beside);
    EXPECT_TRUE(score.add(running, beside));
    EXPECT_EQ(score.running_K(), 2.0);
    EXPECT_EQ(score.beside_K(), 6.0);
  }
}

TEST(TrialScore, where_one_of_both_says_no_number_neither_is_scored) {
  for (const bool of_running : {false, true}) {
    TrialScore score;
    Snapshot running = that_errs({2.0, 2.0}), beside = that_errs({6.0, 6.0});
    (of_running ? running : beside).predicted_K[1] = not_a_value;
    running.uncorrected_K.fill(not_a_value);
    for (int n = 0; n < 3; ++n) EXPECT_EQ(score.add(running, beside), n > 0);
    EXPECT_EQ(score.running_K(), 2.0);
    EXPECT_EQ(score.beside_K(), 6.0);
    EXPECT_TRUE(score.is_beside_worse(judged)) << "no uncorrected model is no better one";
  }
}

TEST(TrialScore, what_was_said_before_a_sensor_was_lost_is_not_held_against_its_return) {
  TrialScore score;
  Snapshot running = that_errs({0.0}), beside = that_errs({0.0});
  running.predicted_K[0] = beside.predicted_K[0] = 200.0;
  score.add(running, beside);
  for (Snapshot* each : {&running, &beside}) {
    each->sensor_quality[0] = SensorQuality::stale;
    each->predicted_K[0] = reading_K - 1.0;
  }
  EXPECT_FALSE(score.add(running, beside));
  for (Snapshot* each : {&running, &beside}) each->sensor_quality[0] = SensorQuality::good;
  EXPECT_TRUE(score.add(running, beside));
  EXPECT_EQ(score.running_K(), 1.0);
}

TEST(TrialScore, worse_begins_beyond_both_margins_and_not_at_them) {
  // 1.25 x 2 + 0.5 = 3
  EXPECT_FALSE(score_of({2.0}, {3.0}).is_beside_worse(judged));
  EXPECT_TRUE(score_of({2.0}, {3.0 + 1e-12}).is_beside_worse(judged));
  EXPECT_FALSE(score_of({0.0}, {0.5}).is_beside_worse(judged));
  EXPECT_TRUE(score_of({0.0}, {0.5 + 1e-12}).is_beside_worse(judged));
  EXPECT_FALSE(score_of({2.0}, {2.0}, 16).is_beside_worse(judged)) << "however many cycles";
  EXPECT_TRUE(score_of({2.0}, {4.0}, 16).is_beside_worse(judged));
}

TEST(TrialScore, the_one_that_runs_is_judged_as_the_one_beside_it) {
  for (const double other_K : {0.0, 2.0, 3.0, 3.25, 7.0}) {
    EXPECT_EQ(score_of({2.0}, {other_K}).is_beside_worse(judged), score_of({other_K}, {2.0}).is_running_worse(judged));
    EXPECT_FALSE(score_of({2.0}, {other_K}).is_running_worse(judged) &&
                 score_of({2.0}, {other_K}).is_beside_worse(judged));
  }
}

TEST(TrialScore, at_one_sensor_is_enough_where_all_together_are_no_worse) {
  for (const int cycles : {1, 4}) {
    const TrialScore score = score_of({8.0, 1.0}, {7.0, 2.0}, cycles);
    EXPECT_LT(score.beside_K(), score.running_K());
    EXPECT_TRUE(score.is_beside_worse(judged)) << cycles;
    EXPECT_TRUE(score_of({7.0, 2.0}, {8.0, 1.0}, cycles).is_running_worse(judged)) << cycles;
    EXPECT_TRUE(score_of({1.0, 8.0}, {2.0, 7.0}, cycles).is_beside_worse(judged)) << "whichever it is";
    EXPECT_FALSE(score_of({8.0, 2.0}, {7.0, 3.0}, cycles).is_beside_worse(judged)) << "at the margin";
  }
}

TEST(TrialScore, a_sensor_that_was_compared_once_counts_by_itself) {
  TrialScore score = score_of({8.0, 1.0}, {7.0, 2.0}, 1);
  Snapshot running = that_errs({8.0, 1.0}), beside = that_errs({7.0, 2.0});
  for (Snapshot* each : {&running, &beside}) each->sensor_quality[1] = SensorQuality::stale;
  for (int n = 0; n < 5; ++n) score.add(running, beside);
  EXPECT_TRUE(score.is_beside_worse(judged));
}

TEST(TrialScore, with_or_without_correction_is_enough) {
  const Errors good{{1.0}, {1.0}}, corrected_worse{{9.0}, {1.0}}, uncorrected_worse{{1.0}, {9.0}};
  EXPECT_TRUE(score_of(good, corrected_worse).is_beside_worse(judged));
  EXPECT_TRUE(score_of(good, uncorrected_worse).is_beside_worse(judged)) << "a correction hides it";
  EXPECT_TRUE(score_of(corrected_worse, good).is_running_worse(judged));
  EXPECT_TRUE(score_of(uncorrected_worse, good).is_running_worse(judged));
  EXPECT_FALSE(score_of(good, good).is_beside_worse(judged));
  EXPECT_FALSE(score_of(good, good).is_running_worse(judged));
}

TEST(TrialScore, without_a_reading_nobody_is_worse) {
  const TrialScore score;
  EXPECT_FALSE(score.is_beside_worse(judged));
  EXPECT_FALSE(score.is_running_worse(judged));
}

TEST(TrialScore, cleared_it_begins_with_the_second_cycle_again) {
  TrialScore score = score_of({2.0}, {9.0}, 5);
  score.clear();
  EXPECT_TRUE(std::isnan(score.running_K()));
  EXPECT_TRUE(std::isnan(score.beside_K()));
  EXPECT_FALSE(score.is_beside_worse(judged));
  EXPECT_FALSE(score.add(that_errs({1.0}), that_errs({1.0}))) << "what was said before is forgotten too";
  EXPECT_TRUE(score.add(that_errs({1.0}), that_errs({1.0})));
  EXPECT_EQ(score.beside_K(), 1.0);
}

}  // namespace cycle_trial_score_test
}  // namespace spindle_twin::firmware
