#include "firmware/watch/clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>

#include "firmware/watch/deadline.hpp"

namespace spindle_twin::firmware {
namespace watch_clock_test {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

/// Each clock stands between two looks at the system's own; the last digits of a double aside.
TEST(Clock, is_that_of_the_system_in_seconds) {
  constexpr double digits_s = 1e-6;
  for (int n = 0; n < 100; ++n) {
    const double wall_s = seconds_of(CLOCK_REALTIME), boot_s = seconds_of(CLOCK_BOOTTIME);
    const double monotonic_s = seconds_of(CLOCK_MONOTONIC);
    const double unix_s = unix_now_s(), since_s = boot_now().s;
    const double now_s = 1e-9 * static_cast<double>(MonotonicClock().now_ns());
    EXPECT_GE(unix_s, wall_s - digits_s);
    EXPECT_LE(unix_s, seconds_of(CLOCK_REALTIME) + digits_s);
    EXPECT_GE(since_s, boot_s - digits_s);
    EXPECT_LE(since_s, seconds_of(CLOCK_BOOTTIME) + digits_s);
    EXPECT_GE(now_s, monotonic_s - digits_s);
    EXPECT_LE(now_s, seconds_of(CLOCK_MONOTONIC) + digits_s);
  }
  EXPECT_EQ(boot_now().boot, boot_now().boot);
}

TEST(Clock, a_sleep_ends_not_before_its_time_and_at_once_where_that_has_passed) {
  MonotonicClock clock;
  const std::int64_t until_ns = clock.now_ns() + 2'000'000;
  clock.sleep_until_ns(until_ns);
  EXPECT_GE(clock.now_ns(), until_ns);
  clock.sleep_until_ns(until_ns);
  clock.sleep_until_ns(0);
}

TEST(Deadline, comes_each_period_from_the_start_however_late_within_it_the_cycle_runs) {
  Deadline deadline(1000, 100);
  EXPECT_EQ(deadline.due_ns(), 1000);
  for (const std::int64_t late_ns : {0, 1, 50, 99}) {
    const std::int64_t due_ns = deadline.due_ns();
    EXPECT_EQ(deadline.take(due_ns + late_ns), 0);
    EXPECT_EQ(deadline.due_ns(), due_ns + 100);
  }
}

TEST(Deadline, whole_periods_that_were_missed_are_counted_and_skipped) {
  for (const auto& [late_ns, missed] : {std::pair{100, 1}, {101, 1}, {199, 1}, {200, 2}, {1050, 10}}) {
    Deadline deadline(1000, 100);
    EXPECT_EQ(deadline.take(1000 + late_ns), missed) << late_ns;
    EXPECT_EQ(deadline.due_ns(), 1000 + 100 * (missed + 1)) << late_ns;
    EXPECT_GT(deadline.due_ns(), 1000 + late_ns);
  }
}

}  // namespace watch_clock_test
}  // namespace spindle_twin::firmware
