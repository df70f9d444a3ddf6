#include "firmware/watch/keep_running.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "tests/firmware/support/logged.hpp"

namespace spindle_twin::firmware {
namespace watch_keep_running_test {

constexpr std::chrono::milliseconds no_pause(0);

TEST(KeepRunning, work_that_throws_begins_again_until_it_returns) {
  const Logged log;
  const std::atomic<bool> stop{false};
  int begun = 0;
  keep_running(
      "history", stop,
      [&] {
        if (++begun < 6) throw std::runtime_error("no such page");
      },
      no_pause);
  EXPECT_EQ(begun, 6);
  const std::string line = "error history failed: no such page; begins again\n";
  EXPECT_EQ(log.text(), line + line + line) << "three lines a minute";
}

TEST(KeepRunning, work_that_goes_on_throwing_ends_with_the_stop) {
  std::atomic<bool> stop{false};
  int begun = 0;
  keep_running(
      "device", stop,
      [&] {
        stop = ++begun == 3;
        throw std::bad_alloc();
      },
      no_pause);
  EXPECT_EQ(begun, 3);
}

TEST(KeepRunning, work_begins_again_behind_a_pause_too) {
  const Logged log;
  const std::atomic<bool> stop{false};
  int begun = 0;
  keep_running(
      "history", stop,
      [&] {
        if (++begun < 3) throw std::runtime_error("no such page");
      },
      std::chrono::milliseconds(25));
  EXPECT_EQ(begun, 3);
}

TEST(KeepRunning, a_stop_does_not_wait_for_the_pause) {
  std::atomic<bool> stop{false};
  std::atomic<int> begun{0};
  std::thread runs([&] {
    keep_running(
        "device", stop,
        [&] {
          ++begun;
          throw std::runtime_error("gone");
        },
        std::chrono::hours(1));
  });
  while (begun == 0) std::this_thread::yield();
  stop = true;
  runs.join();
  EXPECT_EQ(begun, 1);
}

}  // namespace watch_keep_running_test
}  // namespace spindle_twin::firmware
