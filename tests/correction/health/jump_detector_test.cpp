#include "correction/health/jump_detector.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::correction::test {
namespace health_jump_detector_test {

using Meaning = JumpDetector::Meaning;

TEST(JumpDetector, the_third_outlier_that_stays_where_it_went_is_a_jump) {
  JumpDetector detector;
  EXPECT_EQ(detector.note_outlier(2.0, 0.0, {}), Meaning::open);
  EXPECT_EQ(detector.note_outlier(2.1, 0.0, {}), Meaning::open);
  EXPECT_EQ(detector.note_outlier(2.9, 0.0, {}), Meaning::jump) << "less than half of the first step since";
  EXPECT_EQ(detector.in_a_row(), 3);
}

TEST(JumpDetector, what_goes_on_in_the_same_direction_is_the_place) {
  for (const double sign : {-1.0, 1.0}) {
    JumpDetector detector;
    detector.note_outlier(sign * 2.0, 0.0, {});
    detector.note_outlier(sign * 2.6, 0.0, {});
    EXPECT_EQ(detector.note_outlier(sign * 3.2, 0.0, {}), Meaning::place_moves);
    JumpDetector back;
    back.note_outlier(sign * 2.0, 0.0, {});
    back.note_outlier(sign * 1.5, 0.0, {});
    EXPECT_EQ(back.note_outlier(sign * 0.8, 0.0, {}), Meaning::jump);
  }
}

TEST(JumpDetector, only_differences_count_so_that_a_jump_is_the_same_at_every_temperature) {
  for (const double level_K : {0.0, -40.0, 300.0}) {
    for (const double last_K : {2.9, 3.2}) {
      JumpDetector detector;
      detector.note_outlier(level_K + 2.0, level_K, {});
      detector.note_outlier(level_K + 2.5, level_K, {});
      EXPECT_EQ(detector.note_outlier(level_K + last_K, level_K, {}),
                last_K > 3.0 ? Meaning::place_moves : Meaning::jump)
          << "first off by 2 K at " << level_K << " K, then at " << last_K << " K";
    }
  }
}

TEST(JumpDetector, half_of_the_first_step_is_needed_and_a_little_more_is_enough_however_small_the_steps) {
  for (const double first_K : {0.25, -0.25, 4.0, -4.0}) {
    for (const double share : {0.5, 0.515625}) {
      JumpDetector detector;
      detector.note_outlier(first_K, 0.0, {});
      detector.note_outlier(first_K, 0.0, {});
      EXPECT_EQ(detector.note_outlier((1.0 + share) * first_K, 0.0, {}),
                share > 0.5 ? Meaning::place_moves : Meaning::jump)
          << first_K << ' ' << share;
    }
  }
}

TEST(JumpDetector, one_outlier_is_a_row_already) {
  JumpDetector detector;
  detector.note_outlier(2.0, 0.0, {});
  EXPECT_EQ(detector.in_a_row(), 1);
  EXPECT_TRUE(detector.end_row());
  EXPECT_EQ(detector.in_a_row(), 0);
  EXPECT_FALSE(detector.end_row());
}

TEST(JumpDetector, a_row_that_ends_was_a_spike_and_counts_no_more) {
  JumpDetector detector;
  EXPECT_FALSE(detector.end_row());
  detector.note_outlier(2.0, 0.0, {});
  detector.note_outlier(2.0, 0.0, {});
  EXPECT_TRUE(detector.end_row());
  EXPECT_EQ(detector.note_outlier(2.0, 0.0, {}), Meaning::open);
}

}  // namespace health_jump_detector_test
}  // namespace spindle_twin::correction::test
