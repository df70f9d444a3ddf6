#include "correction/health/misfit_review.hpp"

#include <gtest/gtest.h>

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

}  // namespace health_misfit_review_test
}  // namespace spindle_twin::correction::test
