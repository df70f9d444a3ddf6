#include "firmware/login/login_limit.hpp"

#include <gtest/gtest.h>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace login_login_limit_test {

/// Tries let through when one address tries each `each_s` for so long.
int let_through(double each_s, double for_s, int hosts = 1) {
  LoginLimit limit;
  int passed = 0;
  for (int n = 0; n * each_s < for_s; ++n) {
    const auto now_ns = ns_per_s + static_cast<std::int64_t>(1e9 * n * each_s);
    if (limit.wait_s(static_cast<std::uint32_t>(n % hosts), now_ns) == 0.0) ++passed;
  }
  return passed;
}

TEST(LoginLimit, of_one_address_five_at_once_and_then_five_a_minute) {
  LoginLimit limit;
  for (int n = 0; n < 5; ++n) EXPECT_EQ(limit.wait_s(1, 0), 0.0);
  EXPECT_DOUBLE_EQ(limit.wait_s(1, 0), 12.0);
  EXPECT_DOUBLE_EQ(limit.wait_s(1, 5 * ns_per_s), 7.0);
  EXPECT_EQ(limit.wait_s(2, 5 * ns_per_s), 0.0);
  EXPECT_EQ(limit.wait_s(1, 12 * ns_per_s), 0.0);
  EXPECT_GT(limit.wait_s(1, 12 * ns_per_s), 0.0);
  EXPECT_EQ(let_through(0.01, 600.0), 5 + 49);
}

TEST(LoginLimit, of_all_addresses_together_twenty_at_once_and_then_twenty_a_minute) {
  EXPECT_EQ(let_through(0.01, 60.0, 1000), 20 + 19);
  EXPECT_EQ(let_through(4.0, 600.0, 1000), 150);
}

}  // namespace login_login_limit_test
}  // namespace spindle_twin::firmware
