#include "correction/health/usual_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::correction::test {
namespace health_usual_offset_test {

TEST(UsualOffset, is_a_running_mean_of_two_minutes_that_begins_with_the_first) {
  UsualOffset usual;
  EXPECT_EQ(usual.departure_K(4.0), 0.0) << "nothing is known yet";
  usual.learn(1.0, 0.0);
  EXPECT_EQ(usual.departure_K(1.5), 0.5);
  for (int t = 0; t < 120; ++t) usual.learn(2.0, 1.0);
  EXPECT_NEAR(usual.departure_K(2.0), std::exp(-1.0), 1e-9);
  usual.forget();
  EXPECT_EQ(usual.departure_K(4.0), 0.0);
}

}  // namespace health_usual_offset_test
}  // namespace spindle_twin::correction::test
