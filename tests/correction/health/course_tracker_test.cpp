#include "correction/health/course_tracker.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::correction::test {
namespace health_course_tracker_test {

constexpr double stated_noise_K = 0.03;

/// Follows a ramp of so many K/s for so many samples of a second.
CourseTracker on_ramp(double rate_K_per_s, int samples, const HealthLimits& limits) {
  CourseTracker course;
  for (int k = 0; k < samples; ++k) {
    course.carry_on(0.0, 1.0, limits);
    course.accept(300.0 + rate_K_per_s * k, 1.0, stated_noise_K);
  }
  course.carry_on(0.0, 1.0, limits);
  return course;
}

TEST(CourseTracker, follows_a_ramp_without_lag) {
  const CourseTracker course = on_ramp(0.01, 300, {});
  EXPECT_NEAR(course.expected_K(), 300.0 + 0.01 * 300, 1e-6);
}

TEST(CourseTracker, gains_are_those_of_the_alpha_beta_tracker) {
  const HealthLimits limits;
  CourseTracker course = on_ramp(0.0, 10, limits);
  course.accept(301.0, 1.0, stated_noise_K);  // d = 1: c = 300 + α, ċ = β
  course.carry_on(0.0, 2.0, limits);
  EXPECT_NEAR(course.expected_K(), 300.0 + 0.3 + 2.0 * 0.05, 1e-12);
}

TEST(CourseTracker, an_outlier_is_beyond_six_deviations_at_least_jump_K_and_what_the_model_moved) {
  HealthLimits limits;
  CourseTracker course = on_ramp(0.0, 300, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K) << "six times the least noise, 0.01 K, is less";
  EXPECT_FALSE(course.is_outlier(300.0 + 0.299));
  EXPECT_TRUE(course.is_outlier(300.0 + 0.301));
  course.carry_on(-0.5, 1.0, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K + 0.5) << "the model moved within the last four samples";
  for (int k = 0; k < 4; ++k) course.carry_on(0.0, 1.0, limits);
  EXPECT_EQ(course.limit_K(), limits.jump_K);
  limits.jump_K = 0.01;
  course.carry_on(0.0, 1.0, limits);
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

}  // namespace health_course_tracker_test
}  // namespace spindle_twin::correction::test
