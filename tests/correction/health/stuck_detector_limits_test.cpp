#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "correction/health/stuck_detector.hpp"

namespace spindle_twin::correction::test {
namespace health_stuck_detector_limits_test {

constexpr double resolution_K = 0.01;
constexpr StuckDetector::Sensor sensor{resolution_K, 0.03};

StuckDetector::Movements all_move(double model_K) { return {model_K, model_K, model_K}; }

TEST(StuckDetector, needs_four_readings_however_long_they_take) {
  for (const double interval_s : {20.0, 35.0}) {
    StuckDetector detector;
    int readings = 0;
    while (readings < 20) {
      const double time_s = interval_s * readings++;
      if (detector.observe(time_s, 300.0, all_move(0.01 * time_s), sensor, {})) break;
    }
    EXPECT_EQ(readings, 4);
  }
}

/// Stretches begin each ten seconds: the first without the change at 5 s begins at 10 s.
TEST(StuckDetector, a_quarter_of_two_minutes_without_a_change_is_enough) {
  StuckDetector detector;
  int found_s = -1;
  for (int t = 0; t < 200 && found_s < 0; ++t) {
    if (detector.observe(t, t < 5 ? 300.0 : 301.0, all_move(0.1 * t), sensor, {})) found_s = t;
  }
  EXPECT_EQ(found_s, 40);
}

TEST(StuckDetector, movements_of_exactly_what_is_needed_will_do_half_of_it_for_the_last_two) {
  HealthLimits limits;
  limits.stuck_K = 0.125;
  for (std::size_t less = 0; less <= 3; ++less) {
    StuckDetector detector;
    bool found = false;
    for (int t = 0; t < 100; ++t) {
      StuckDetector::Movements model_K{};
      if (t >= 20) model_K = {0.125, -0.0625, 0.0625};
      if (less < 3) model_K[less] *= 0.96875;
      found = found || detector.observe(t, 300.0, model_K, sensor, limits);
    }
    EXPECT_EQ(found, less == 3) << less;
  }
}

TEST(StuckDetector, after_a_restart_nothing_counts_of_what_was_before) {
  StuckDetector detector;
  for (int t = 0; t < 1000; ++t) detector.observe(t, 300.0 + 0.05 * (t % 2), all_move(0.01 * t), sensor, {});
  int t = 1000;
  for (; t < 1025; ++t) EXPECT_FALSE(detector.observe(t, 300.0, all_move(0.01 * t), sensor, {}));
  detector.restart();
  const int begin = t += 100;
  for (; t <= begin + 30; ++t) {
    EXPECT_EQ(detector.observe(t, 300.0, all_move(0.01 * t), sensor, {}), t == begin + 30) << t - begin;
  }
}

TEST(StuckDetector, after_a_restart_the_first_reading_repeats_none) {
  StuckDetector detector;
  int t = 0;
  for (; t < 2000; ++t) detector.observe(t, 300.0 + 0.05 * (t % 2), {}, sensor, {});
  detector.observe(t++, 300.05, {}, sensor, {});
  detector.restart();
  for (int readings = 1; readings <= 4; ++readings) {
    detector.observe(t++, 300.05, {}, sensor, {});
    EXPECT_EQ(detector.repeats(), readings == 4) << readings;
  }
}

TEST(StuckDetector, of_a_channel_that_changes_each_time_three_repeats_are_too_many) {
  StuckDetector detector;
  int t = 0;
  for (; t < 2000; ++t) detector.observe(t, 300.0 + 0.05 * (t % 2), {}, sensor, {});
  for (int repeats = 1; repeats <= 10; ++repeats) {
    detector.observe(t++, 300.05, {}, sensor, {});
    EXPECT_EQ(detector.repeats(), repeats >= 3) << repeats;
  }
  detector.observe(t++, 300.15, {}, sensor, {});
  EXPECT_FALSE(detector.repeats()) << "it lives";
}

TEST(StuckDetector, what_flickers_by_one_step_of_resolution_does_not_change) {
  StuckDetector detector;
  int t = 0;
  for (; t < 2000; ++t) detector.observe(t, 300.0 + resolution_K * (t % 2), {}, sensor, {});
  for (int n = 0; n < 20; ++n) detector.observe(t++, 300.0, {}, sensor, {});
  EXPECT_FALSE(detector.repeats());
}

TEST(StuckDetector, a_smooth_rise_that_comes_to_its_end_is_not_stuck) {
  for (const double direction : {1.0, -1.0}) {
    StuckDetector detector;
    int t = 0;
    for (; t < 1000; ++t) detector.observe(t, 300.0 + direction * 0.05 * t, {}, sensor, {});
    for (int n = 0; n < 200; ++n) {
      detector.observe(t++, 300.0 + direction * 50.0, {}, sensor, {});
      EXPECT_FALSE(detector.repeats());
    }
  }
}

/// Share of changes by its definition: each reading weighs 0.98 of the next one; of noise two changes in three turn
/// back.
struct Shares {
  void note(double change_K) {
    const bool changed = std::abs(change_K) > 1.0001 * resolution_K;
    changes.push_back(changed ? 1.0 : 0.0);
    turns.push_back(changed && change_K * last_K < 0.0 ? 1.0 : 0.0);
    if (changed) last_K = change_K;
  }
  static double of(const std::vector<double>& what) {
    double share = 0.0;
    for (const double each : what) share += 0.02 * (each - share);
    return share;
  }
  double changing() const { return std::min(of(changes), 1.5 * of(turns)); }
  double last_K = 0.0;
  std::vector<double> changes, turns;
};

TEST(StuckDetector, repeats_that_a_live_channel_would_have_once_in_a_thousand_runs_are_too_many) {
  std::mt19937_64 random(20261127);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  constexpr double in_turns = -1.0;
  for (const double up : {0.0, 0.5, 0.9, in_turns}) {
    for (const double pause : {0.3, 0.8, 0.9}) {
      StuckDetector detector;
      Shares shares;
      double reading_K = 300.0;
      int t = 0, repeated = 0;
      const auto rises = [&](double share) { return share < 0.0 ? shares.last_K < 0.0 : unit(random) < share; };
      detector.observe(t++, reading_K, {}, sensor, {});
      for (; t < 400; ++t) {
        const double change_K = t < 300 && unit(random) > pause ? (rises(up) ? 0.1 : -0.1) : 0.0;
        const bool withheld = detector.repeats();
        reading_K += change_K;
        detector.observe(t, reading_K, {}, sensor, {});
        if (!withheld) {
          shares.note(change_K);
        } else if (change_K != 0.0) {
          shares.last_K = change_K;
        }
        repeated = change_K == 0.0 ? repeated + 1 : 0;
        const bool expected = repeated >= 3 && std::pow(1.0 - shares.changing(), repeated) < 1e-3;
        ASSERT_EQ(detector.repeats(), expected) << "seed 20261127, " << up << ' ' << pause << ' ' << t;
      }
    }
  }
}

}  // namespace health_stuck_detector_limits_test
}  // namespace spindle_twin::correction::test
