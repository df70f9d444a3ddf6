#include "correction/health/stuck_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace spindle_twin::correction::test {
namespace health_stuck_detector_test {

constexpr double resolution_K = 0.01;
constexpr StuckDetector::Sensor sensor{resolution_K, 0.03};

TEST(StuckDetector, equal_readings_are_stuck_once_the_model_has_moved_far_enough_for_long_enough) {
  for (const double rate_K_per_s : {0.01, 0.002}) {
    StuckDetector detector;
    double found_s = -1.0;
    for (int t = 0; t < 600 && found_s < 0.0; ++t) {
      const double model_K = rate_K_per_s * t;
      if (detector.observe(t, 300.0, {model_K, model_K, model_K}, sensor, {})) found_s = t;
    }
    // 0.1 K, and a quarter of the window; buckets begin every 10 s.
    EXPECT_GE(found_s, std::max(30.0, 0.1 / rate_K_per_s));
    EXPECT_LE(found_s, std::max(30.0, 0.1 / rate_K_per_s) + 10.0);
  }
}

/// The model goes on by 0.12 K at once; a sensor of lag τ would show 0.05 K of it after τ ln(0.12/0.07), τ 30 s more
/// than it is said to be.
TEST(StuckDetector, waits_for_what_a_sensor_of_its_lag_would_show) {
  for (const double lag_s : {0.0, 60.0, 120.0, 300.0}) {
    const double shown_s = (lag_s + 30.0) * std::log(0.12 / 0.07);
    StuckDetector detector;
    double found_s = -1.0;
    for (int t = 0; t < 300 && found_s < 0.0; ++t) {
      const double model_K = t < 40 ? 0.0 : 0.12;
      if (detector.observe(t, 300.0, {model_K, model_K, model_K}, {resolution_K, 0.03, lag_s}, {})) found_s = t - 39;
    }
    if (shown_s > 110.0) {
      EXPECT_LT(found_s, 0.0) << lag_s << ": longer than the window";
    } else {
      EXPECT_NEAR(found_s, shown_s, 1.0) << lag_s;
    }
  }
}

TEST(StuckDetector, a_model_that_takes_longer_than_two_minutes_for_a_tenth_of_a_kelvin_shows_nothing) {
  for (const double movement_s : {100.0, 125.0, 200.0}) {
    StuckDetector detector;
    bool found = false;
    for (int t = 0; t < 3600; ++t) {
      const double model_K = 0.1 / movement_s * t;
      found = found || detector.observe(t, 300.0, {model_K, model_K, model_K}, sensor, {});
    }
    EXPECT_EQ(found, movement_s < 120.0) << movement_s;
  }
}

/// Read each 10 s a live sensor of a place that stands shows four readings within a step once in some hundred minutes.
TEST(StuckDetector, while_the_model_settles_its_movement_is_not_held_against_a_sensor_that_stands) {
  int taken_for_stuck = 0;
  for (const bool settles : {false, true}) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> noise_K(0.0, 0.03);
    StuckDetector detector;
    const StuckDetector::Sensor of{resolution_K, 0.03, 0.0, settles};
    int found = 0;
    for (int t = 0; t < 900000; t += 10) {
      const double model_K = 0.01 * t, reading_K = std::round((300.0 + noise_K(random)) / resolution_K) * resolution_K;
      found += detector.observe(t, reading_K, {model_K, model_K, model_K}, of, {}) ? 1 : 0;
    }
    if (settles) {
      EXPECT_EQ(found, 0);
    } else {
      taken_for_stuck = found;
    }
  }
  EXPECT_GT(taken_for_stuck, 0) << "the test shows nothing";
  StuckDetector dead;
  double found_s = -1.0;
  for (int t = 0; t < 600 && found_s < 0.0; ++t) {
    const double model_K = 0.01 * t;
    if (dead.observe(t, 300.0, {model_K, model_K, model_K}, {resolution_K, 0.03, 0.0, true}, {})) found_s = t;
  }
  EXPECT_GE(found_s, 0.0);
  EXPECT_LE(found_s, 60.0) << "its own noise is missed";
}

TEST(StuckDetector, a_coarse_channel_needs_eight_steps_of_its_resolution) {
  constexpr double coarse_K = 0.05;
  for (const double moved_K : {0.36, 0.44}) {
    StuckDetector detector;
    bool found = false;
    for (int t = 0; t < 300; ++t) {
      const double model_K = moved_K * std::min(1.0, t / 60.0);
      found = found || detector.observe(t, 300.0, {model_K, model_K, model_K}, {coarse_K, 0.03}, {});
    }
    EXPECT_EQ(found, moved_K > 8.0 * coarse_K) << moved_K;
  }
}

TEST(StuckDetector, all_three_forms_of_the_model_must_move_the_last_two_half_as_far) {
  for (std::size_t stands = 0; stands <= 3; ++stands) {
    StuckDetector detector;
    bool found = false;
    for (int t = 0; t < 300; ++t) {
      StuckDetector::Movements model_K{0.01 * t, 0.005 * t, 0.005 * t};
      if (stands < 3) model_K[stands] = 0.0;
      found = found || detector.observe(t, 300.0, model_K, sensor, {});
    }
    EXPECT_EQ(found, stands == 3) << stands;
  }
}

TEST(StuckDetector, one_step_of_resolution_is_no_movement_and_two_are) {
  for (const double steps : {1.0, 2.0}) {
    StuckDetector detector;
    bool found = false;
    for (int t = 0; t < 300; ++t) {
      const double model_K = 0.01 * t;
      const double reading_K = 300.0 + (t % 2) * steps * resolution_K;
      found = found || detector.observe(t, reading_K, {model_K, model_K, model_K}, sensor, {});
    }
    EXPECT_EQ(found, steps < 1.5);
  }
}

TEST(StuckDetector, a_live_channel_that_falls_silent_repeats_and_a_coarse_one_does_not) {
  for (const int changes_every : {1, 10}) {
    StuckDetector detector;
    int t = 0;
    for (; t < 1000; ++t) {
      detector.observe(t, 300.0 + 0.05 * ((t / changes_every) % 2), {}, sensor, {});
    }
    EXPECT_FALSE(detector.repeats());
    for (int k = 0; k < 10; ++k) detector.observe(t++, 301.0, {}, sensor, {});
    EXPECT_EQ(detector.repeats(), changes_every == 1);
  }
}

}  // namespace health_stuck_detector_test
}  // namespace spindle_twin::correction::test
