#include "correction/health/course_tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace spindle_twin::correction::test {
namespace health_course_tracker_test {

constexpr double stated_noise_K = 0.03;

/// Follows a ramp of so many K/s for so many samples of a second.
CourseTracker on_ramp(double rate_K_per_s, int samples, const HealthLimits& limits) {
  CourseTracker course;
  for (int k = 0; k < samples; ++k) {
    course.carry_on(0.0, 1.0, 0.01, limits);
    course.accept(300.0 + rate_K_per_s * k, 1.0, stated_noise_K);
  }
  course.carry_on(0.0, 1.0, 0.01, limits);
  return course;
}

TEST(CourseTracker, follows_a_ramp_without_lag) {
  const CourseTracker course = on_ramp(0.01, 300, {});
  EXPECT_NEAR(course.expected_K(), 300.0 + 0.01 * 300, 1e-6);
}

TEST(CourseTracker, begins_anew_at_the_rate_that_is_known_and_judges_after_three) {
  CourseTracker course = on_ramp(0.0, 50, {});
  course.begin(305.0, 0.5, stated_noise_K);
  for (int k = 1; k <= 3; ++k) {
    course.carry_on(0.0, 2.0, 0.01, {});
    EXPECT_NEAR(course.expected_K(), 305.0 + 0.5 * 2.0 * k, 1e-9) << k;
    EXPECT_EQ(course.is_outlier(400.0), k == 3) << k;
    course.accept(305.0 + 0.5 * 2.0 * k, 2.0, stated_noise_K);
  }
}

TEST(CourseTracker, gains_are_those_of_the_alpha_beta_tracker) {
  const HealthLimits limits;
  CourseTracker course = on_ramp(0.0, 10, limits);
  course.accept(301.0, 1.0, stated_noise_K);  // d = 1: c = 300 + α, ċ = β
  course.carry_on(0.0, 2.0, 0.01, limits);
  EXPECT_NEAR(course.expected_K(), 300.0 + 0.3 + 2.0 * 0.05, 1e-12);
}

TEST(CourseTracker, an_outlier_is_beyond_six_deviations_at_least_jump_K_and_what_the_model_moved) {
  HealthLimits limits;
  CourseTracker course = on_ramp(0.0, 300, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K) << "six times the least noise, 0.01 K, is less";
  EXPECT_FALSE(course.is_outlier(300.0 + 0.299));
  EXPECT_TRUE(course.is_outlier(300.0 + 0.301));
  course.carry_on(-0.5, 1.0, 0.01, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K + 0.5) << "the model moved within the last four samples";
  for (int k = 0; k < 4; ++k) course.carry_on(0.0, 1.0, 0.01, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K);
  limits.jump_K = 0.01;
  course.carry_on(0.0, 1.0, 0.01, limits);
  EXPECT_NEAR(course.limit_K(), 6.0 * stated_noise_K / 3.0, 1e-12) << "a third of the stated noise is the least";
}

TEST(CourseTracker, nothing_is_an_outlier_before_three_samples) {
  const HealthLimits limits;
  for (int samples = 0; samples <= 3; ++samples) {
    const CourseTracker course = on_ramp(0.0, samples, limits);
    EXPECT_EQ(course.is_outlier(310.0), samples >= 3);
  }
  CourseTracker course = on_ramp(0.0, 10, limits);
  course.restart();
  EXPECT_FALSE(course.is_outlier(310.0));
}

/// By its equations, over readings that come in irregular steps.
TEST(CourseTracker, course_and_limit_are_those_of_the_equations) {
  HealthLimits limits;
  limits.jump_K = 0.01;
  limits.jump_share = 0.5;
  CourseTracker course;
  std::mt19937_64 random(20261127);
  std::normal_distribution<double> unit(0.0, 1.0);
  double value_K = 0.0, slope_K_per_s = 0.0, deviation_K = stated_noise_K;
  std::vector<double> moved_K(4, 0.0);
  for (int n = 0; n < 300; ++n) {
    const double h_s = n % 7 == 3 ? 0.0 : 0.5 * (1 + n % 3);
    moved_K.push_back(0.02 * unit(random));
    course.carry_on(moved_K.back(), h_s, 0.01, limits);
    double expected_K = value_K + slope_K_per_s * h_s, movement_K = 0.0;
    for (std::size_t k = moved_K.size() - 4; k < moved_K.size(); ++k) movement_K += std::abs(moved_K[k]);
    EXPECT_NEAR(course.expected_K(), expected_K, 1e-9) << n;
    if (n > 0) {
      EXPECT_NEAR(course.limit_K(), std::max(0.01, 6.0 * deviation_K) + 0.5 * movement_K, 1e-9) << n;
    }
    // Noise of twice what is stated, then of a tenth and of ten times, where what is learnt comes to its bounds.
    const double noise_K = stated_noise_K * (n < 100 ? 2.0 : n < 200 ? 0.1 : 10.0);
    const double reading_K = 300.0 + 0.01 * n + noise_K * unit(random);
    course.accept(reading_K, h_s, stated_noise_K);
    if (n == 0) expected_K = reading_K;
    const double off_K = reading_K - expected_K;
    value_K = expected_K + 0.3 * off_K;
    if (h_s > 0.0) slope_K_per_s += 0.05 * off_K / h_s;
    // √(π/2) times the mean of |d| is σ.
    deviation_K = 0.98 * deviation_K + 0.02 * 1.2533 * std::abs(off_K);
    deviation_K = std::clamp(deviation_K, stated_noise_K / 3.0, stated_noise_K * 3.0);
  }
}

TEST(CourseTracker, after_a_restart_neither_slope_nor_noise_is_known) {
  HealthLimits limits;
  limits.jump_K = 0.01;
  CourseTracker course = on_ramp(0.5, 50, limits);
  course.restart();
  course.accept(400.0, 1.0, stated_noise_K);
  course.carry_on(0.0, 1.0, 0.01, limits);
  EXPECT_EQ(course.expected_K(), 400.0);
  EXPECT_NEAR(course.limit_K(), 6.0 * 0.98 * stated_noise_K, 1e-12);
  for (int samples = 1; samples <= 3; ++samples) {
    EXPECT_EQ(course.is_outlier(410.0), samples == 3);
    course.accept(400.0, 1.0, stated_noise_K);
    course.carry_on(0.0, 1.0, 0.01, limits);
  }
}

}  // namespace health_course_tracker_test
}  // namespace spindle_twin::correction::test
