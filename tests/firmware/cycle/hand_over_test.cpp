#include "firmware/cycle/hand_over.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

#include "firmware/watch/deadline.hpp"

namespace spindle_twin::firmware {
namespace cycle_hand_over_test {

/// All entries equal, so that a torn copy shows.
struct Wide {
  std::array<std::uint64_t, 300> entries{};
};

TEST(Latest, nothing_is_new_until_written_and_each_value_is_new_once) {
  Latest<int> latest;
  int value = -1;
  EXPECT_FALSE(latest.read(value));
  EXPECT_EQ(value, -1);
  latest.write(1);
  latest.write(2);
  EXPECT_TRUE(latest.read(value));
  EXPECT_EQ(value, 2);
  EXPECT_FALSE(latest.read(value));
}

TEST(Latest, values_are_whole_and_never_go_back_between_threads) {
  constexpr std::uint64_t last = 200000;
  Latest<Wide> latest;
  std::thread writer([&] {
    Wide wide;
    for (std::uint64_t n = 1; n <= last; ++n) {
      wide.entries.fill(n);
      latest.write(wide);
    }
  });
  Wide seen;
  std::uint64_t before = 0;
  bool whole = true;
  bool forward = true;
  while (before < last) {
    if (!latest.read(seen)) continue;
    for (const std::uint64_t entry : seen.entries) whole = whole && entry == seen.entries[0];
    forward = forward && seen.entries[0] > before;
    before = seen.entries[0];
  }
  writer.join();
  EXPECT_TRUE(whole);
  EXPECT_TRUE(forward);
}

TEST(Ring, keeps_order_between_threads_and_refuses_when_full) {
  Ring<int, 4> small;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(small.push(i));
  EXPECT_FALSE(small.push(4));
  int value = -1;
  EXPECT_TRUE(small.pop(value));
  EXPECT_EQ(value, 0);
  EXPECT_TRUE(small.push(4));

  constexpr int last = 100000;
  Ring<int, 64> ring;
  std::thread writer([&] {
    for (int n = 0; n <= last; ++n) {
      while (!ring.push(n)) std::this_thread::yield();
    }
  });
  bool in_order = true;
  for (int expected = 0; expected <= last;) {
    if (!ring.pop(value)) continue;
    in_order = in_order && value == expected;
    ++expected;
  }
  writer.join();
  EXPECT_TRUE(in_order);
}

TEST(Deadline, on_time_misses_nothing_and_stays_on_the_grid) {
  Deadline deadline(100, 10);
  EXPECT_EQ(deadline.take(100), 0);
  EXPECT_EQ(deadline.due_ns(), 110);
  EXPECT_EQ(deadline.take(119), 0);
  EXPECT_EQ(deadline.due_ns(), 120);
}

TEST(Deadline, whole_periods_late_are_missed_and_skipped) {
  Deadline deadline(0, 10);
  EXPECT_EQ(deadline.take(35), 3);
  EXPECT_EQ(deadline.due_ns(), 40);
}

}  // namespace cycle_hand_over_test
}  // namespace spindle_twin::firmware
