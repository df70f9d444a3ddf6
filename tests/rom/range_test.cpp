#include "rom/range.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace spindle_twin::rom::tests {
namespace range_test {

constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(Range, an_end_belongs_to_it_unless_it_is_excluded_and_what_is_not_finite_never) {
  for (const bool low_excluded : {false, true}) {
    for (const bool high_excluded : {false, true}) {
      const Range range{-2.0, 3.0, low_excluded, high_excluded};
      EXPECT_EQ(is_allowed(range, -2.0), !low_excluded);
      EXPECT_EQ(is_allowed(range, 3.0), !high_excluded);
      EXPECT_TRUE(is_allowed(range, std::nextafter(-2.0, 0.0)));
      EXPECT_TRUE(is_allowed(range, std::nextafter(3.0, 0.0)));
      EXPECT_FALSE(is_allowed(range, std::nextafter(-2.0, -9.0)));
      EXPECT_FALSE(is_allowed(range, std::nextafter(3.0, 9.0)));
    }
  }
  for (const Range& range : {any_number, positive, not_negative, Range{-1.0, infinite}, Range{-infinite, 1.0}}) {
    for (const double none : {std::nan(""), infinite, -infinite}) EXPECT_FALSE(is_allowed(range, none));
  }
}

TEST(Range, those_with_a_name_are_what_they_say) {
  for (const double value : {-1e300, -1.0, 0.0, 1e300}) EXPECT_TRUE(is_allowed(any_number, value));
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_FALSE(is_allowed(positive, 0.0));
  EXPECT_TRUE(is_allowed(positive, least));
  EXPECT_TRUE(is_allowed(positive, 1e300));
  EXPECT_TRUE(is_allowed(not_negative, 0.0));
  EXPECT_FALSE(is_allowed(not_negative, -least));
  EXPECT_TRUE(is_allowed(between(4.0, 5.0), 4.0));
  EXPECT_TRUE(is_allowed(between(4.0, 5.0), 5.0));
}

TEST(Range, says_in_words_which_ends_it_has_and_whether_they_belong_to_it) {
  EXPECT_EQ(allowed(any_number), "a finite number");
  EXPECT_EQ(allowed(positive), "a number above 0");
  EXPECT_EQ(allowed(not_negative), "a number of at least 0");
  EXPECT_EQ(allowed({-infinite, 4.5}), "a number of at most 4.5");
  EXPECT_EQ(allowed({-infinite, 4.5, false, true}), "a number below 4.5");
  EXPECT_EQ(allowed(between(-1.0, 2.0)), "a number from -1 to 2");
  EXPECT_EQ(allowed({-1.0, 2.0, true, false}), "a number from -1 (excluded) to 2");
  EXPECT_EQ(allowed({-1.0, 2.0, false, true}), "a number from -1 to 2 (excluded)");
}

}  // namespace range_test
}  // namespace spindle_twin::rom::tests
