#include "firmware/show/shown_spindle.hpp"

#include <gtest/gtest.h>

#include <string>

#include "firmware/cycle/publish.hpp"
#include "firmware/show/routes.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace show_shown_spindle_test {

SpindleToShow to_show(const std::string& name = "") {
  SpindleToShow spindle;
  spindle.name = name;
  spindle.names = names_of(tests::small_network());
  return spindle;
}

Snapshot cycle(State state, std::int64_t time_ns) {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.state = state;
  snapshot.time_ns = time_ns;
  snapshot.sequence = 9;
  return snapshot;
}

TEST(ShownSpindle, a_cycle_is_dead_that_is_three_periods_late_or_five_seconds_where_that_is_longer) {
  EXPECT_EQ(stale_after_s(0.1), 5.0);
  EXPECT_EQ(stale_after_s(1.5), 5.0);
  EXPECT_EQ(stale_after_s(2.0), 6.0);
  EXPECT_EQ(stale_after_s(60.0), 180.0);
}

TEST(ShownSpindle, is_healthy_where_the_prediction_may_be_used) {
  for (const auto& [state, status] :
       {std::pair{State::starting, 503}, {State::running, 200}, {State::degraded, 200}, {State::fault, 503}}) {
    ShownSpindle spindle(to_show());
    spindle.tap().write(cycle(state, ns_per_s));
    spindle.renew(ns_per_s);
    EXPECT_EQ(spindle.health(ns_per_s).status, status) << static_cast<int>(state);
  }
}

TEST(ShownSpindle, is_healthy_until_its_cycle_is_older_than_it_may_be) {
  SpindleToShow quick = to_show();
  quick.stale_after_s = 2.0;
  for (const auto& [spindle_to_show, after_s] : {std::pair{to_show(), 5}, {quick, 2}}) {
    ShownSpindle spindle(spindle_to_show);
    constexpr std::int64_t began_ns = 7 * ns_per_s;
    spindle.tap().write(cycle(State::running, began_ns));
    spindle.renew(began_ns);
    EXPECT_EQ(spindle.health(began_ns + after_s * ns_per_s).status, 200);
    EXPECT_EQ(spindle.health(began_ns + after_s * ns_per_s + 1000).status, 503);
  }
}

TEST(ShownSpindle, says_which_of_several_is_not_healthy_and_the_only_one_needs_no_name) {
  EXPECT_EQ(ShownSpindle(to_show("left")).health(0).body, "{\"error\":\"left: no prediction that may be used\"}\n");
  EXPECT_EQ(ShownSpindle(to_show()).health(0).body, "{\"error\":\"no prediction that may be used\"}\n");
}

TEST(ShownSpindle, the_newest_cycle_counts_from_when_it_is_taken) {
  ShownSpindle spindle(to_show());
  EXPECT_EQ(spindle.sequence(), 0U);
  spindle.tap().write(cycle(State::running, 1));
  EXPECT_EQ(spindle.sequence(), 0U);
  spindle.renew(1);
  EXPECT_EQ(spindle.sequence(), 9U);
  EXPECT_EQ(spindle.summary(), "{\"name\":\"\",\"unit\":1,\"spindle\":\"small\",\"state\":\"running\"}");
}

TEST(ShownSpindle, only_hours_that_are_offered_are_asked_of_a_history) {
  SpindleToShow with = to_show();
  with.history = [](int hours, const std::atomic<bool>&) { return Page{200, "text/plain", std::to_string(hours)}; };
  const ShownSpindle spindle(with);
  const std::atomic<bool> stop{false};
  for (const int hours : history_hours) {
    const Page page = spindle.history(std::to_string(hours));
    ASSERT_TRUE(page.work) << hours;
    EXPECT_EQ(page.work(stop).body, std::to_string(hours));
  }
  for (const char* hours : {"", "0", "2", "08", "8.0", "169", "-1"}) {
    const Page page = spindle.history(hours);
    EXPECT_FALSE(page.work) << hours;
    EXPECT_EQ(page.status, 400) << hours;
  }
  EXPECT_TRUE(spindle.has_history());
}

TEST(ShownSpindle, what_is_not_kept_is_not_found) {
  const ShownSpindle spindle(to_show());
  EXPECT_FALSE(spindle.has_history());
  EXPECT_EQ(spindle.history("8").status, 404);
  EXPECT_EQ(spindle.growth().status, 404);
}

}  // namespace show_shown_spindle_test
}  // namespace spindle_twin::firmware
