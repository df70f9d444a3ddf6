#include "firmware/watch/log_limit.hpp"

#include <gtest/gtest.h>

#include <string>

namespace spindle_twin::firmware {
namespace watch_log_limit_test {

constexpr std::int64_t s_ns = 1'000'000'000;

TEST(LogLimitByItself, three_lines_pass_in_a_minute_from_the_first_of_them) {
  for (const std::int64_t began_ns : {std::int64_t{0}, 5 * s_ns, 1'000'000 * s_ns}) {
    LogLimit limit;
    EXPECT_EQ(limit.pass(began_ns), 0U);
    EXPECT_EQ(limit.pass(began_ns + 30 * s_ns), 0U);
    EXPECT_EQ(limit.pass(began_ns + 60 * s_ns - 1), 0U);
    EXPECT_FALSE(limit.pass(began_ns + 60 * s_ns - 1));
    EXPECT_EQ(limit.pass(began_ns + 60 * s_ns), 1U) << "and the one that did not";
    EXPECT_EQ(limit.pass(began_ns + 60 * s_ns), 0U) << "said once";
    EXPECT_EQ(limit.pass(began_ns + 120 * s_ns - 1), 0U);
    EXPECT_FALSE(limit.pass(began_ns + 120 * s_ns - 1));
  }
}

TEST(LogLimitByItself, one_that_was_held_back_is_said_too) {
  EXPECT_EQ(LogLimit::also(0), "");
  EXPECT_EQ(LogLimit::also(1), " (and 1 times that were not logged)");
}

}  // namespace watch_log_limit_test
}  // namespace spindle_twin::firmware
