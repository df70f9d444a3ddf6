#include "correction/estimator/consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace spindle_twin::correction::test {
namespace estimator_consistency_test {

constexpr double update_period_s = 10.0;
constexpr double sigma_K = 0.05;      // of one reading
constexpr double counted_as_one = 6;  // readings of a minute, in the variance that the filter expects

/// One update: all sensors alike.
bool all(Consistency& consistency, double innovation_K, bool rejected = false, int sensors = 4) {
  const double variance_K2 = counted_as_one * sigma_K * sigma_K;
  for (int s = 0; s < sensors; ++s) consistency.note(s, innovation_K, variance_K2, 1e-4, rejected, update_period_s);
  return consistency.conclude(update_period_s);
}

double at_ratio(double nis) { return std::sqrt(nis * counted_as_one) * sigma_K; }

TEST(Consistency, healthy_innovations_never_contradict_in_a_day) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, sigma_K);
    Consistency consistency({}, 6);
    double largest = 0.0;
    for (double time_s = update_period_s; time_s <= 86400.0; time_s += update_period_s) {
      for (Eigen::Index s = 0; s < 6; ++s) {
        consistency.note(s, normal(random), counted_as_one * sigma_K * sigma_K, sigma_K * sigma_K, false,
                         update_period_s);
      }
      EXPECT_FALSE(consistency.conclude(update_period_s)) << time_s;
      largest = std::max(largest, consistency.largest_nis());
    }
    EXPECT_EQ(consistency.contradictions(), 0);
    EXPECT_FALSE(consistency.in_doubt());
    EXPECT_LT(largest, 1.0);
    EXPECT_NEAR(consistency.nis_of_hour(), 1.0 / counted_as_one, 0.1 / counted_as_one);
  }
}

TEST(Consistency, a_mean_square_innovation_above_what_is_expected_contradicts_after_a_minute) {
  const ConsistencyLimits limits;
  Consistency consistency(limits, 4);
  double time_s = 0.0, above_s = 0.0;
  bool found = false;
  while (!found && time_s < 600.0) {
    time_s += update_period_s;
    found = all(consistency, at_ratio(4.0));
    const double mean = 4.0 * (1.0 - std::exp(-time_s / limits.nis_memory_s));
    if (above_s == 0.0 && mean > limits.nis) above_s = time_s;
  }
  EXPECT_EQ(time_s, above_s - update_period_s + 60.0);
  EXPECT_TRUE(consistency.in_doubt());
  EXPECT_EQ(consistency.contradictions(), 1);
  EXPECT_DOUBLE_EQ(consistency.largest_innovation_K(), at_ratio(4.0));
}

TEST(Consistency, below_what_is_expected_nothing_ever_contradicts) {
  Consistency consistency({}, 4);
  for (double time_s = update_period_s; time_s <= 7200.0; time_s += update_period_s) {
    EXPECT_FALSE(all(consistency, at_ratio(0.98)));
  }
  EXPECT_NEAR(consistency.nis(0), 0.98, 1e-9);
}

TEST(Consistency, one_reading_at_three_deviations_does_not_contradict) {
  Consistency consistency({}, 4);
  all(consistency, at_ratio(9.0));
  EXPECT_NEAR(consistency.nis(0), 9.0 * (1.0 - std::exp(-update_period_s / 60.0)), 1e-12);
  for (double time_s = 2.0 * update_period_s; time_s <= 600.0; time_s += update_period_s) {
    EXPECT_FALSE(all(consistency, 0.0));
  }
}

TEST(Consistency, readings_that_are_mostly_rejected_contradict) {
  Consistency consistency({}, 4);
  double time_s = 0.0;
  while (!consistency.in_doubt() && time_s < 3600.0) {
    time_s += update_period_s;
    all(consistency, 0.0, true);
  }
  // 1 − e^(−t/300) exceeds a half from 208 s on, a minute later it has done so for a minute.
  EXPECT_NEAR(time_s, 300.0 * std::log(2.0) + 60.0, 1.01 * update_period_s);
  Consistency half({}, 4);
  for (time_s = update_period_s; time_s <= 3600.0; time_s += update_period_s) {
    for (Eigen::Index s = 0; s < 4; ++s) half.note(s, 0.0, 1.0, 1e-4, s < 2, update_period_s);
    EXPECT_FALSE(half.conclude(update_period_s));
  }
}

TEST(Consistency, doubt_ends_after_a_calm_minute_and_not_before) {
  Consistency consistency({}, 4);
  consistency.contradict();
  EXPECT_TRUE(consistency.in_doubt());
  for (int k = 1; k <= 5; ++k) {
    all(consistency, 0.0);
    EXPECT_TRUE(consistency.in_doubt()) << k;
  }
  all(consistency, 0.0);
  EXPECT_FALSE(consistency.in_doubt());
  consistency.contradict();
  for (int k = 1; k <= 100; ++k) {
    // 0.9 (1 − e^(−t/60)) exceeds what is calm from 49 s on: never calm for a whole minute.
    all(consistency, at_ratio(0.9));
    EXPECT_TRUE(consistency.in_doubt()) << k;
  }
}

TEST(Consistency, before_the_first_reading_nothing_is_doubted_large_or_rejected) {
  const Consistency consistency(ConsistencyLimits{}, 2);
  EXPECT_FALSE(consistency.in_doubt());
  EXPECT_EQ(consistency.largest_innovation_K(), 0.0);
  EXPECT_EQ(consistency.rejected_share(), 0.0);
  EXPECT_EQ(consistency.contradictions(), 0);
}

TEST(Consistency, without_a_reading_nothing_is_concluded) {
  Consistency consistency({}, 4);
  consistency.contradict();
  for (int k = 1; k <= 100; ++k) EXPECT_FALSE(consistency.conclude(update_period_s));
  EXPECT_TRUE(consistency.in_doubt());
}

TEST(Consistency, the_floor_follows_the_rms_of_what_is_not_explained_between_its_limits) {
  const ConsistencyLimits limits;
  const auto floor_after = [&](double rms_K, bool rejected) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    Consistency consistency(limits, 1);
    double mean_K2 = 0.0;
    int count = 0;
    for (double time_s = update_period_s; time_s <= 8.0 * 3600.0; time_s += update_period_s) {
      consistency.note(0, rms_K * normal(random), 100.0, 0.02 * 0.02, rejected, update_period_s);
      consistency.conclude(update_period_s);
      if (time_s < 2.0 * 3600.0) continue;
      mean_K2 += std::pow(consistency.floor_K(0), 2);
      ++count;
    }
    return std::sqrt(mean_K2 / count);
  };
  EXPECT_NEAR(floor_after(0.2, false), std::sqrt(0.2 * 0.2 - 0.02 * 0.02), 0.01);
  EXPECT_NEAR(floor_after(0.01, false), limits.floor_K, 1e-12);
  EXPECT_NEAR(floor_after(5.0, false), limits.floor_largest_K, 1e-3);
  EXPECT_NEAR(floor_after(0.2, true), limits.floor_K, 1e-12) << "a rejected reading says nothing of the network";
}

TEST(Consistency, limits_are_those_that_are_stated) {
  const ConsistencyLimits limits;
  EXPECT_EQ(limits.floor_K, 0.03) << "one reading's noise";
  EXPECT_EQ(limits.floor_largest_K, 1.0);
  EXPECT_EQ(limits.floor_memory_s, 1800.0);
  EXPECT_EQ(limits.nis, 1.5);
  EXPECT_EQ(limits.nis_memory_s, 60.0);
  EXPECT_EQ(limits.patience_s, 60.0);
  EXPECT_EQ(limits.calm_nis, 0.5);
  EXPECT_EQ(limits.rejected_memory_s, 300.0);
  EXPECT_EQ(limits.rejected_share, 0.5);
}

/// What was seen last is all that is remembered.
ConsistencyLimits without_memory() {
  ConsistencyLimits limits;
  limits.nis_memory_s = limits.rejected_memory_s = limits.floor_memory_s = 1e-3;
  return limits;
}

TEST(Consistency, a_statistic_at_its_limit_is_not_above_it_and_one_at_what_is_calm_is_not_calm) {
  const ConsistencyLimits limits = without_memory();
  Consistency consistency(limits, 2);
  const auto minutes_of = [&](double square_K2, int rejected) {  // whether it was found in five minutes
    bool found = false;
    for (int k = 0; k < 30; ++k) {
      for (Eigen::Index s = 0; s < 2; ++s) {
        consistency.note(s, std::sqrt(square_K2), 4.0, 0.0, s < rejected, update_period_s);
      }
      found = consistency.conclude(update_period_s) || found;
    }
    return found;
  };
  EXPECT_FALSE(minutes_of(0.25 * 4.0, 1)) << "half of the readings rejected";
  EXPECT_TRUE(minutes_of(2.25 * 4.0, 0));
  ASSERT_TRUE(consistency.in_doubt());
  EXPECT_FALSE(minutes_of(0.25 * 4.0, 1));
  EXPECT_TRUE(consistency.in_doubt()) << "half of the readings rejected is not calm";
  EXPECT_FALSE(minutes_of(0.25 * 4.0, 0));
  EXPECT_FALSE(consistency.in_doubt());

  ConsistencyLimits met = limits;  // squares of round numbers, so that the means are the limits to the last bit
  met.nis = 2.25;
  met.calm_nis = 0.25;
  consistency = Consistency(met, 2);
  EXPECT_FALSE(minutes_of(2.25 * 4.0, 0));
  consistency.contradict();
  EXPECT_FALSE(minutes_of(0.25 * 4.0, 0));
  EXPECT_TRUE(consistency.in_doubt());
}

TEST(Consistency, patience_is_a_whole_minute_also_of_updates_each_second_and_begins_anew_after_each_that_is_neither) {
  Consistency consistency(without_memory(), 1);
  const auto second = [&](double square_K2) {
    consistency.note(0, std::sqrt(square_K2), 1.0, 0.0, false, 1.0);
    return consistency.conclude(1.0);
  };
  for (int k = 1; k <= 59; ++k) EXPECT_FALSE(second(2.0)) << k;
  EXPECT_FALSE(second(1.0));
  for (int k = 1; k <= 59; ++k) EXPECT_FALSE(second(2.0)) << k;
  EXPECT_TRUE(second(2.0));
  for (int k = 1; k <= 59; ++k) second(0.1);
  second(1.0);
  for (int k = 1; k <= 59; ++k) second(0.1);
  EXPECT_TRUE(consistency.in_doubt());
  second(0.1);
  EXPECT_FALSE(consistency.in_doubt());
}

TEST(Consistency, of_one_reading_no_more_than_twelve_counts) {
  Consistency consistency(without_memory(), 1);
  consistency.note(0, std::sqrt(11.0), 1.0, 0.0, false, update_period_s);
  EXPECT_NEAR(consistency.nis(0), 11.0, 1e-9);
  consistency.note(0, 100.0, 1.0, 0.0, false, update_period_s);
  EXPECT_NEAR(consistency.nis(0), 12.0, 1e-9);
}

TEST(Consistency, means_follow_the_time_since_a_sensors_reading_before_and_fade_with_their_memories) {
  const ConsistencyLimits limits;
  Consistency consistency(limits, 3);
  const auto gone = [](double elapsed_s, double memory_s) { return 1.0 - std::exp(-elapsed_s / memory_s); };
  consistency.note(0, 0.4, 0.08, 0.01, false, 10.0);
  consistency.note(1, -0.3, 0.045, 0.01, true, 25.0);
  EXPECT_NEAR(consistency.square_K2(0), 0.16 * gone(10.0, 60.0), 1e-12);
  EXPECT_NEAR(consistency.square_K2(1), 0.09 * gone(25.0, 60.0), 1e-12);
  EXPECT_NEAR(consistency.nis(0), 2.0 * gone(10.0, 60.0), 1e-12);
  EXPECT_NEAR(consistency.nis(1), 2.0 * gone(25.0, 60.0), 1e-12);
  EXPECT_EQ(consistency.nis(2), 0.0);
  EXPECT_EQ(consistency.largest_nis(), consistency.nis(1));
  const double least_K2 = limits.floor_K * limits.floor_K;
  EXPECT_NEAR(consistency.floor_K(0), std::sqrt(least_K2 + gone(10.0, 1800.0) * (0.16 - 0.01 - least_K2)), 1e-12);
  EXPECT_EQ(consistency.floor_K(1), limits.floor_K) << "it was rejected";
  consistency.conclude(20.0);
  EXPECT_EQ(consistency.largest_innovation_K(), 0.4);
  EXPECT_NEAR(consistency.rejected_share(), 0.5 * gone(20.0, 300.0), 1e-12);
  EXPECT_NEAR(consistency.nis_of_hour(), 2.0 * gone(20.0, 3600.0), 1e-12);
  const double square_K2 = consistency.square_K2(0);
  const double nis = consistency.nis(0), of_hour = consistency.nis_of_hour(), share = consistency.rejected_share();
  consistency.note(0, 0.1, 0.01, 0.01, false, 20.0);
  consistency.conclude(20.0);
  EXPECT_EQ(consistency.largest_innovation_K(), 0.1) << "of the update that was concluded last";
  EXPECT_NEAR(consistency.square_K2(0), square_K2 + gone(20.0, 60.0) * (0.01 - square_K2), 1e-12);
  EXPECT_NEAR(consistency.nis(0), nis + gone(20.0, 60.0) * (1.0 - nis), 1e-12);
  EXPECT_NEAR(consistency.nis_of_hour(), of_hour + gone(20.0, 3600.0) * (1.0 - of_hour), 1e-12);
  EXPECT_NEAR(consistency.rejected_share(), share * std::exp(-20.0 / 300.0), 1e-12);
}

TEST(Consistency, a_contradiction_begins_the_means_anew_and_holds_the_floor_at_its_least_until_it_fits_again) {
  const ConsistencyLimits limits;
  Consistency consistency(limits, 4);
  consistency.set_floor(2, 0.5);
  EXPECT_DOUBLE_EQ(consistency.floor_K(2), 0.5);
  all(consistency, 0.4, true);
  ASSERT_GT(consistency.rejected_share(), 0.0);
  consistency.contradict();
  EXPECT_EQ(consistency.contradictions(), 1);
  EXPECT_EQ(consistency.largest_nis(), 0.0);
  EXPECT_EQ(consistency.rejected_share(), 0.0);
  EXPECT_DOUBLE_EQ(consistency.floor_K(2), limits.floor_K);
  all(consistency, 0.4);
  EXPECT_DOUBLE_EQ(consistency.floor_K(2), limits.floor_K) << "in doubt its innovations are not the network's";
  while (consistency.in_doubt()) all(consistency, 0.0);
  all(consistency, 0.4);
  EXPECT_GT(consistency.floor_K(2), limits.floor_K);
}

TEST(Consistency, contradictions_a_minute_apart_are_two_and_a_restart_knows_of_none_of_the_doubt) {
  Consistency consistency({}, 4);
  std::vector<double> found_s;
  for (double time_s = update_period_s; time_s <= 600.0; time_s += update_period_s) {
    if (all(consistency, at_ratio(12.0))) found_s.push_back(time_s);
  }
  // The mean is above 1.5 with the first reading, and again with the first after each: each minute one.
  ASSERT_EQ(found_s.size(), 10U);
  for (std::size_t k = 0; k < found_s.size(); ++k) EXPECT_EQ(found_s[k], 60.0 * static_cast<double>(k + 1));
  EXPECT_EQ(consistency.contradictions(), 10);
  all(consistency, at_ratio(12.0));
  consistency.restart();
  EXPECT_FALSE(consistency.in_doubt());
  EXPECT_EQ(consistency.largest_nis(), 0.0);
  EXPECT_EQ(consistency.square_K2(0), 0.0);
  EXPECT_EQ(consistency.nis_of_hour(), 0.0);
  EXPECT_EQ(consistency.rejected_share(), 0.0);
  for (int k = 1; k <= 5; ++k) EXPECT_FALSE(all(consistency, at_ratio(12.0))) << "patience is whole again";
  EXPECT_TRUE(all(consistency, at_ratio(12.0)));
}

TEST(Consistency, a_floor_whose_largest_is_below_its_least_stays_at_its_least) {
  ConsistencyLimits limits = without_memory();
  limits.floor_largest_K = 0.01;
  Consistency consistency(limits, 1);
  consistency.note(0, 5.0, 1.0, 0.0, false, update_period_s);
  EXPECT_DOUBLE_EQ(consistency.floor_K(0), limits.floor_K);
  limits.floor_largest_K = 2.0;
  consistency = Consistency(limits, 1);
  consistency.note(0, 5.0, 1.0, 0.0, false, update_period_s);
  EXPECT_DOUBLE_EQ(consistency.floor_K(0), 2.0);
  consistency.note(0, 1.0, 1.0, 0.75, false, update_period_s);
  EXPECT_NEAR(consistency.floor_K(0), 0.5, 1e-9);
}

TEST(Consistency, of_no_sensors_has_no_statistic) {
  const Consistency consistency;
  EXPECT_EQ(consistency.largest_nis(), 0.0);
  EXPECT_EQ(consistency.least_floor_K(), 0.03);
}

}  // namespace estimator_consistency_test
}  // namespace spindle_twin::correction::test
