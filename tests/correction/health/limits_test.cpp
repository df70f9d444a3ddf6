#include "correction/health/limits.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "correction/health/surprise.hpp"
#include "correction/health/swap_detector.hpp"

namespace spindle_twin::correction::test {
namespace health_limits_test {

constexpr double update_s = 10.0, channel_noise_K = 0.03;

/// Those that nobody sets, by where each comes from.
TEST(HealthLimits, are_what_their_derivations_say) {
  const HealthLimits limits;
  EXPECT_EQ(limits.electrical, 2) << "one may be a disturbed telegram";
  EXPECT_DOUBLE_EQ(limits.gap_s, limits.jump_K / 0.01) << "the model errs by a jump";
  EXPECT_EQ(limits.gap_intervals, 5.0);
  EXPECT_EQ(limits.outliers, 3) << "a disturbance may meet two samples";
  EXPECT_EQ(limits.stuck_resolutions, 8.0);
  EXPECT_EQ(limits.drift_wait_s, 12.0 * update_s);
  EXPECT_EQ(limits.settle_s, 15.0 * 60.0);
  EXPECT_EQ(limits.drift_least_s, 120.0);
  EXPECT_EQ(limits.second_opinion_s, 2.0 * 3600.0);
  EXPECT_EQ(limits.opinion_least_s, 30.0 * update_s);
  EXPECT_EQ(limits.opinion_deviations, 2.0);
  EXPECT_EQ(limits.doubt_share, 0.5);
  EXPECT_EQ(limits.review_s, 600.0);
  EXPECT_EQ(limits.review_deviations, 3.0);
  EXPECT_EQ(limits.review_share, 0.5);
  EXPECT_EQ(limits.swap_support, limits.drift_lead);
  EXPECT_NEAR(limits.swap_K, 3.0 * channel_noise_K, 0.02);
  EXPECT_EQ(limits.swap_gain, 0.35);
  EXPECT_EQ(limits.swap_memory_s, evidence_memory_s);
  EXPECT_EQ(limits.swap_least_s, 3.0 * 60.0);
  EXPECT_EQ(limits.swap_evidence, 0.25 * limits.drift_limit);
  EXPECT_EQ(limits.swap_s, limits.drift_least_s);
}

/// Measured ones: the share of its movement that a place is met to, its own 0.04 to 0.16.
TEST(HealthLimits, of_swapped_channels_lie_between_what_healthy_and_swapped_ones_show) {
  const HealthLimits limits;
  EXPECT_GT(limits.swap_fit, 0.16);
  EXPECT_LT(limits.swap_fit, 0.5);
  EXPECT_GT(limits.swap_floor, 0.04);
  EXPECT_LT(limits.swap_floor, 0.1);
  EXPECT_GT(limits.swap_share, 0.25);
  EXPECT_LE(limits.swap_share, 0.5);
  EXPECT_GT(limits.swap_alike, 0.5);
  EXPECT_LT(limits.swap_alike, 1.0);
}

TEST(SwapDetector, compares_at_steps_of_speed_at_seats_and_at_the_whole_spindle) {
  EXPECT_EQ(SwapDetector::scales_s, (std::array{60.0, 300.0, 1200.0}));
}

TEST(Surprise, is_the_square_of_the_ratio_up_to_three_deviations_and_of_no_number_the_most) {
  EXPECT_DOUBLE_EQ(surprise(0.3, 0.04), 2.25);
  EXPECT_DOUBLE_EQ(surprise(-0.3, 0.04), 2.25);
  EXPECT_DOUBLE_EQ(surprise(0.59, 0.04), 0.59 * 0.59 / 0.04);
  EXPECT_EQ(surprise(0.61, 0.04), 9.0);
  EXPECT_EQ(surprise(std::numeric_limits<double>::quiet_NaN(), 0.04), 9.0);
}

TEST(Surprise, is_remembered_for_an_hour) { EXPECT_EQ(evidence_memory_s, 3600.0); }

}  // namespace health_limits_test
}  // namespace spindle_twin::correction::test
