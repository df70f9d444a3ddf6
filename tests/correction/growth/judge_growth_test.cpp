#include "correction/growth/judge_growth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace spindle_twin::correction {
namespace judge_growth_test {

constexpr double ever = std::numeric_limits<double>::infinity();
constexpr double um = 1e-6;

/// A warm-up of 12 um within two hours, read each ten minutes; `published` of it is what the twin says.
std::vector<GrowthReading> warm_up(double published, ReadingOrigin origin = ReadingOrigin::touch_off) {
  std::vector<GrowthReading> readings;
  for (int n = 0; n <= 12; ++n) {
    const double grown_m = 12.0 * um * (1.0 - std::exp(-n / 4.0));
    readings.push_back({600.0 * n, 0, origin, grown_m, published * grown_m});
  }
  return readings;
}

TEST(JudgeGrowth, a_perfect_prediction_leaves_nothing) {
  const GrowthJudgement judged = judge_growth(warm_up(1.0), -ever, ever);
  EXPECT_EQ(judged.readings, 12U) << "the first is the zero";
  EXPECT_EQ(judged.left_rms_m, 0.0);
  EXPECT_NEAR(judged.growth_worst_m, 12.0 * um * (1.0 - std::exp(-3.0)), 1e-12);
  EXPECT_EQ(judged.verdict, Verdict::helps);
}

TEST(JudgeGrowth, the_wrong_sign_doubles_the_growth_and_makes_it_worse) {
  const GrowthJudgement judged = judge_growth(warm_up(-1.0), -ever, ever);
  EXPECT_NEAR(judged.left_rms_m, 2.0 * judged.growth_rms_m, 1e-15);
  EXPECT_EQ(judged.verdict, Verdict::makes_worse);
}

TEST(JudgeGrowth, zeros_of_measurement_and_prediction_are_of_no_account_in_each_stretch) {
  std::vector<GrowthReading> readings = warm_up(0.9);
  for (std::size_t n = 0; n < readings.size(); ++n) {
    readings[n].stretch = n < 6 ? 0 : 1;
    readings[n].measured_m += n < 6 ? 3.0 * um : -70.0 * um;
    readings[n].predicted_m += n < 6 ? -20.0 * um : 5.0 * um;
  }
  const GrowthJudgement judged = judge_growth(readings, -ever, ever);
  EXPECT_EQ(judged.readings, 11U);
  EXPECT_NEAR(judged.left_rms_m, 0.1 * judged.growth_rms_m, 1e-15);
}

TEST(JudgeGrowth, a_week_counts_its_own_readings_against_a_zero_of_the_week_before) {
  const std::vector<GrowthReading> readings = warm_up(0.5);
  const GrowthJudgement first = judge_growth(readings, 0.0, 3600.0), second = judge_growth(readings, 3600.0, 7200.0);
  EXPECT_EQ(first.readings, 5U);
  EXPECT_EQ(second.readings, 6U) << "7200 s belong to the next";
  EXPECT_GT(second.growth_rms_m, first.growth_rms_m);
}

TEST(JudgeGrowth, parts_made_with_compensation_are_judged_against_what_was_published) {
  const auto judged = [](double applied) {
    std::vector<GrowthReading> parts = warm_up(1.0, ReadingOrigin::by_hand_compensated);
    for (GrowthReading& part : parts) part.measured_m -= applied * part.predicted_m;
    return judge_growth(parts, -ever, ever);
  };
  EXPECT_NEAR(judged(0.8).left_rms_m, 0.2 * judged(0.8).growth_rms_m, 1e-15);
  EXPECT_EQ(judged(0.8).verdict, Verdict::helps);
  EXPECT_NEAR(judged(-1.0).left_rms_m, 2.0 * judged(-1.0).growth_rms_m, 1e-15);
  EXPECT_EQ(judged(-1.0).verdict, Verdict::makes_worse);
  EXPECT_EQ(judged(0.0).verdict, Verdict::not_told);
}

TEST(JudgeGrowth, where_neither_growth_nor_prediction_stands_out_of_the_noise_nothing_is_told) {
  std::mt19937_64 random(20261123);
  std::normal_distribution<double> normal;
  int told = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<GrowthReading> readings = {{0.0, 0, ReadingOrigin::touch_off, 0.0, 0.0}};
    for (int n = 1; n <= 20; ++n) {
      readings.push_back(
          {60.0 * n, 0, ReadingOrigin::touch_off, 2.0 * um * normal(random), 0.01 * um * normal(random)});
    }
    told += judge_growth(readings, -ever, ever).verdict != Verdict::not_told ? 1 : 0;
  }
  EXPECT_LE(told, 20) << "5 % are beyond two standard errors, seed 20261123";
  EXPECT_EQ(judge_growth(std::vector<GrowthReading>(3), -ever, ever).verdict, Verdict::too_few);
}

TEST(JudgeGrowth, weeks_begin_on_monday_and_only_those_with_growth_are_told) {
  constexpr double monday_s = 1'793'577'600.0, day_s = 86400.0;  // 2 November 2026
  std::vector<GrowthReading> readings;
  for (const double day : {-1.0, 0.0, 6.9, 20.0}) {
    readings.push_back({monday_s + day * day_s, 0, ReadingOrigin::touch_off, day * um, 0.5 * day * um});
  }
  const std::vector<GrowthWeek> weeks = judge_weeks(readings);
  ASSERT_EQ(weeks.size(), 2U) << "the week of the zero has nothing to tell, the one between has no reading";
  EXPECT_EQ(weeks[0].from_unix_s, monday_s);
  EXPECT_EQ(weeks[0].judged.readings, 2U);
  EXPECT_EQ(weeks[1].from_unix_s, monday_s + 14.0 * day_s);
  EXPECT_TRUE(judge_weeks({}).empty());
}

TEST(JudgeGrowth, three_readings_after_the_zero_are_enough_and_two_are_not) {
  const std::vector<GrowthReading> whole = warm_up(1.0);
  const std::vector<GrowthReading> four(whole.begin(), whole.begin() + 4), three(whole.begin(), whole.begin() + 3);
  EXPECT_EQ(judge_growth(four, -ever, ever).verdict, Verdict::helps);
  EXPECT_TRUE(measured_times(four));
  EXPECT_EQ(judge_growth(three, -ever, ever).verdict, Verdict::too_few);
  EXPECT_FALSE(measured_times(three));
}

TEST(JudgeGrowth, how_many_times_the_published_growth_was_measured_has_the_sign_of_what_is_wrong) {
  for (const double published : {1.0, -1.0, 2.0, 0.5}) {
    const auto times = measured_times(warm_up(published));
    ASSERT_TRUE(times);
    EXPECT_NEAR(*times, 1.0 / published, 1e-12);
  }
  EXPECT_FALSE(measured_times(warm_up(1.0, ReadingOrigin::by_hand_compensated)));
  EXPECT_FALSE(measured_times(warm_up(0.01))) << "hardly any published growth";
}

/// Readings whose with² − without² are these, of a published growth of 1: left = measured − 1.
std::vector<GrowthReading> with_differences(const std::vector<double>& differences) {
  std::vector<GrowthReading> readings = {{0.0, 0, ReadingOrigin::touch_off, 0.0, 0.0}};
  for (const double difference : differences) {
    readings.push_back({60.0, 0, ReadingOrigin::touch_off, 0.5 * (1.0 - difference), 1.0});
  }
  return readings;
}

TEST(JudgeGrowth, a_mean_beyond_two_standard_errors_is_told_and_within_it_is_not) {
  // Of four that lie 1 above and below their mean the standard error is √(4/3/4).
  const double error = 2.0 * std::sqrt(1.0 / 3.0);
  for (const double share : {-1.01, -0.99, 0.0, 0.99, 1.01}) {
    const double mean = share * error;
    const auto judged = judge_growth(with_differences({mean + 1, mean - 1, mean + 1, mean - 1}), -ever, ever);
    EXPECT_EQ(judged.verdict, share > 1.0    ? Verdict::makes_worse
                              : share < -1.0 ? Verdict::helps
                                             : Verdict::not_told)
        << share;
  }
}

TEST(JudgeGrowth, the_worst_is_the_largest_either_way_with_its_sign) {
  std::vector<GrowthReading> readings = {{0.0, 0, ReadingOrigin::touch_off, 0.0, 0.0}};
  for (const auto& [measured, published] : {std::pair{3.0, 2.0}, {-5.0, -2.0}, {4.0, 5.0}}) {
    readings.push_back({60.0, 0, ReadingOrigin::touch_off, measured * um, published * um});
  }
  const GrowthJudgement judged = judge_growth(readings, -ever, ever);
  EXPECT_DOUBLE_EQ(judged.growth_worst_m, -5.0 * um);
  EXPECT_DOUBLE_EQ(judged.left_worst_m, -3.0 * um);
  EXPECT_DOUBLE_EQ(judged.growth_rms_m, std::sqrt((9.0 + 25.0 + 16.0) / 3.0) * um);
  EXPECT_DOUBLE_EQ(judged.left_rms_m, std::sqrt((1.0 + 9.0 + 1.0) / 3.0) * um);
}

TEST(JudgeGrowth, nothing_is_told_where_there_is_nothing_but_a_first_reading) {
  const GrowthJudgement judged = judge_growth(std::vector<GrowthReading>(1), -ever, ever);
  EXPECT_EQ(judged.readings, 0U);
  EXPECT_EQ(judged.growth_rms_m, 0.0);
  EXPECT_EQ(judged.left_rms_m, 0.0);
  EXPECT_EQ(judged.growth_worst_m, 0.0);
  EXPECT_EQ(judged.left_worst_m, 0.0);
}

TEST(JudgeGrowth, a_micrometre_rms_of_published_growth_is_enough_and_less_is_not) {
  for (const double rms_um : {0.99, 1.01}) {
    std::vector<GrowthReading> touch_offs = {{0.0, 0, ReadingOrigin::touch_off, 0.0, 0.0}};
    for (const double share : {0.6, 0.8, 1.0, 1.0, 1.4, 1.0}) {  // sum of squares 5.96
      const double published_m = share / std::sqrt(5.96 / 6.0) * rms_um * um;
      touch_offs.push_back({60.0, 0, ReadingOrigin::touch_off, 3.0 * published_m, published_m});
    }
    const auto times = measured_times(touch_offs);
    ASSERT_EQ(times.has_value(), rms_um > 1.0);
    EXPECT_NEAR(times.value_or(3.0), 3.0, 1e-12);
  }
}

TEST(JudgeGrowth, a_week_reaches_from_monday_midnight_to_the_next) {
  constexpr double monday_s = 1'793'577'600.0, week_s = 7.0 * 86400.0;  // 2 November 2026
  std::vector<GrowthReading> readings = {{monday_s - week_s, 0, ReadingOrigin::touch_off, 0.0, 0.0}};
  for (const double at_s : {monday_s, monday_s + week_s - 1.0, monday_s + week_s, monday_s + 2.0 * week_s - 1.0}) {
    readings.push_back({at_s, 0, ReadingOrigin::touch_off, um, um});
  }
  const std::vector<GrowthWeek> weeks = judge_weeks(readings);
  ASSERT_EQ(weeks.size(), 2U);
  for (std::size_t w = 0; w < 2; ++w) {
    EXPECT_EQ(weeks[w].from_unix_s, monday_s + static_cast<double>(w) * week_s);
    EXPECT_EQ(weeks[w].judged.readings, 2U);
  }
  readings.resize(2);
  EXPECT_EQ(judge_weeks(readings).size(), 1U) << "one reading is told of too";
}

TEST(AppliedScale, at_its_limits_belongs_to_what_is_nearer_to_a_whole_number) {
  for (const double off : {-0.25, 0.25}) {
    EXPECT_EQ(applied_as(1.0 + off), AppliedAs::as_published);
    EXPECT_EQ(applied_as(-1.0 + off), AppliedAs::wrong_sign);
    EXPECT_EQ(applied_as(off), AppliedAs::not_at_all);
  }
  EXPECT_EQ(applied_as(1.5), AppliedAs::not_told);
  EXPECT_EQ(applied_as(0.5), AppliedAs::not_told);
}

TEST(AppliedScale, is_found_from_what_compensated_parts_have_left) {
  const auto left_of = [](double applied) {
    std::vector<GrowthReading> parts = warm_up(1.0, ReadingOrigin::by_hand_compensated);
    for (GrowthReading& part : parts) part.measured_m -= applied * part.predicted_m;
    return parts;
  };
  struct Case {
    double applied;
    AppliedAs expected;
  };
  for (const Case& c : {Case{1.0, AppliedAs::as_published},
                        {-1.0, AppliedAs::wrong_sign},
                        {0.0, AppliedAs::not_at_all},
                        {0.1, AppliedAs::not_at_all},
                        {0.3937, AppliedAs::wrong_scale},
                        {10.0, AppliedAs::wrong_scale},
                        {-10.0, AppliedAs::wrong_scale},
                        {1.3, AppliedAs::not_told},
                        {0.76, AppliedAs::as_published},
                        {0.74, AppliedAs::not_told},
                        {-0.76, AppliedAs::wrong_sign},
                        {-0.74, AppliedAs::wrong_scale},
                        {0.24, AppliedAs::not_at_all},
                        {0.26, AppliedAs::wrong_scale},
                        {0.49, AppliedAs::wrong_scale},
                        {0.51, AppliedAs::not_told},
                        {1.49, AppliedAs::not_told},
                        {1.51, AppliedAs::wrong_scale}}) {
    const auto scale = applied_scale(left_of(c.applied));
    ASSERT_TRUE(scale);
    EXPECT_NEAR(*scale, c.applied, 1e-12);
    EXPECT_EQ(applied_as(scale), c.expected) << c.applied;
  }
  EXPECT_FALSE(applied_scale(warm_up(1.0))) << "touch-offs do not tell what the control does";
  std::vector<GrowthReading> cold = left_of(1.0);
  for (GrowthReading& part : cold) part.predicted_m *= 0.01;
  EXPECT_FALSE(applied_scale(cold)) << "hardly any growth";
  EXPECT_EQ(applied_as(std::nullopt), AppliedAs::not_told);
}

}  // namespace judge_growth_test
}  // namespace spindle_twin::correction
