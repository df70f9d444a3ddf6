#include "correction/health/misfit_review.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::correction::test {
namespace health_misfit_review_test {

/// What so many seconds of a misfit say after a verdict of 1 K with that deviation.
bool gone_after(double seconds, double misfit_K, double deviation_K) {
  MisfitReview review;
  review.begin(0.0, 1.0, deviation_K, false);
  for (double t = 0.0; t < seconds; t += 1.0) review.note(misfit_K, 1.0);
  return review.has_gone({});
}

TEST(MisfitReview, a_misfit_has_gone_when_a_minute_of_it_is_half_of_what_it_was_and_within_three_deviations) {
  EXPECT_FALSE(gone_after(600.0, 1.0, 0.5)) << "within three deviations, but what it was";
  EXPECT_FALSE(gone_after(600.0, 0.45, 0.1)) << "half of it, but beyond three deviations";
  EXPECT_TRUE(gone_after(600.0, 0.45, 0.2));
  EXPECT_TRUE(gone_after(600.0, -0.45, 0.2));
  EXPECT_FALSE(gone_after(30.0, 0.0, 1.0)) << "e^-1/2 is left";
  EXPECT_TRUE(gone_after(50.0, 0.0, 1.0));
}

TEST(MisfitReview, is_over_after_ten_minutes_unless_the_model_was_in_doubt) {
  for (const bool in_doubt : {false, true}) {
    MisfitReview review;
    EXPECT_FALSE(review.is_over(1e6, {}));
    review.begin(100.0, 1.0, 0.1, in_doubt);
    EXPECT_EQ(review.will_latch(), !in_doubt);
    EXPECT_FALSE(review.is_over(700.0, {}));
    EXPECT_EQ(review.is_over(701.0, {}), !in_doubt);
    review.dismiss();
    EXPECT_FALSE(review.is_active());
    EXPECT_FALSE(review.is_over(1e6, {}));
  }
}

TEST(MisfitReview, exactly_three_deviations_and_exactly_half_have_gone) {
  for (const double misfit_K : {0.5, 0.5001}) {
    MisfitReview half, three;
    half.begin(0.0, 1.0, 1.0, false);
    three.begin(0.0, 4.0, 0.125, false);
    half.note(misfit_K, 1e9);
    three.note(misfit_K - 0.125, 1e9);
    EXPECT_EQ(half.has_gone({}), misfit_K == 0.5);
    EXPECT_EQ(three.has_gone({}), misfit_K == 0.5);
  }
}

TEST(MisfitReview, a_verdict_is_judged_by_the_mean_of_a_minute_that_begins_with_its_own_misfit) {
  MisfitReview review;
  review.begin(0.0, -2.0, 1.0, false);
  EXPECT_FALSE(review.has_gone({}));
  const double seconds = 60.0 * std::log(2.0);  // until half is left
  review.note(0.0, 0.5 * seconds);
  review.note(0.0, 0.49 * seconds);
  EXPECT_FALSE(review.has_gone({}));
  review.note(0.0, 0.02 * seconds);
  EXPECT_TRUE(review.has_gone({}));
}

TEST(MisfitReview, each_verdict_says_anew_whether_it_may_latch) {
  MisfitReview review;
  EXPECT_FALSE(review.is_active());
  EXPECT_FALSE(review.will_latch());
  review.begin(0.0, 1.0, 0.1, true);
  EXPECT_TRUE(review.is_active());
  EXPECT_FALSE(review.will_latch());
  review.begin(1000.0, 1.0, 0.1, false);
  EXPECT_TRUE(review.will_latch());
  EXPECT_FALSE(review.is_over(1600.0, {}));
  EXPECT_TRUE(review.is_over(1600.5, {}));
}

}  // namespace health_misfit_review_test
}  // namespace spindle_twin::correction::test
