#include "firmware/keep/event_log.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/small_network.hpp"

/// The lines of single events, word for word.
namespace spindle_twin::firmware {
namespace keep_event_log_test {

constexpr std::int64_t s_ns = 1'000'000'000;

/// Cycles a minute apart, so that no line is held back.
struct Log {
  std::string told(const Snapshot& now) {
    const Logged lines;
    events.note(now, time_ns += 60 * s_ns);
    return lines.text();
  }
  std::string told_of_clock(double unix_s, std::int64_t now_ns) {
    const Logged lines;
    events.note_clock(unix_s, now_ns);
    return lines.text();
  }
  const rom::Network network = tests::small_network();
  EventLog events{network};
  std::int64_t time_ns = 0;
};

TEST(EventLogLines, the_first_state_is_said_and_then_each_change_with_all_that_is_amiss) {
  Log log;
  Snapshot now;
  EXPECT_EQ(log.told(now), "info state starting, quality: none\n") << "also where it is that of before any";
  EXPECT_EQ(log.told(now), "");
  now.state = State::degraded;
  now.quality = bits(Quality::sensor_missing) | bits(Quality::estimate_in_doubt);
  EXPECT_EQ(log.told(now), "info state degraded, quality: sensor_missing, estimate_in_doubt\n");
  now.quality = 0;
  EXPECT_EQ(log.told(now), "") << "what is amiss alone makes no line";
}

TEST(EventLogLines, of_faults_those_that_came_and_those_that_went) {
  Log log;
  Snapshot now;
  log.told(now);
  now.fault = bits(Fault::integrator_failed) | bits(Fault::output_clamped);
  EXPECT_EQ(log.told(now), "warning fault integrator_failed, output_clamped\n");
  now.fault = bits(Fault::integrator_failed) | bits(Fault::history_lost);
  EXPECT_EQ(log.told(now), "warning fault history_lost\ninfo fault output_clamped is over\n");
  now.fault = 0;
  EXPECT_EQ(log.told(now), "info fault integrator_failed, history_lost is over\n");
}

TEST(EventLogLines, of_a_sensor_that_is_swapped_the_other_one_is_said) {
  Log log;
  Snapshot now;
  log.told(now);
  now.sensor_health[0] = {SensorState::failed, SensorFault::swapped, 2};
  EXPECT_EQ(log.told(now), "warning sensor sleeve_inner: failed, swapped with sleeve_outer\n");
  now.sensor_health[0] = {};
  log.told(now);
  now.sensor_health[0] = {SensorState::failed, SensorFault::open, 2};
  EXPECT_EQ(log.told(now), "warning sensor sleeve_inner: failed, open\n");
}

TEST(EventLogLines, a_sensor_is_said_when_it_fails_and_when_it_is_believed_again) {
  Log log;
  Snapshot now;
  log.told(now);
  for (const std::size_t k : {0U, 2U}) {
    const std::string sensor = k == 0 ? "sleeve_inner" : "sleeve_outer";
    SensorHealthState& health = now.sensor_health[k];
    health.state = SensorState::suspect;
    EXPECT_EQ(log.told(now), "") << "it is not judged yet";
    health = {SensorState::failed, SensorFault::stuck};
    EXPECT_EQ(log.told(now), "warning sensor " + sensor + ": failed, stuck\n");
    EXPECT_EQ(log.told(now), "");
    health.state = SensorState::returning;
    EXPECT_EQ(log.told(now), "") << "on probation";
    health.state = SensorState::failed;
    EXPECT_EQ(log.told(now), "warning sensor " + sensor + ": failed, stuck\n") << "again";
    health.state = SensorState::returning;
    log.told(now);
    health.state = SensorState::suspect;
    EXPECT_EQ(log.told(now), "info sensor " + sensor + ": believed again\n");
  }
  now.sensor_health[3] = {SensorState::failed, SensorFault::stuck};
  EXPECT_EQ(log.told(now), "") << "the network has no such key point";
}

TEST(EventLogLines, an_order_is_said_with_each_result_but_not_while_it_waits_the_oldest_first) {
  Log log;
  Snapshot now;
  now.last_orders[0] = {1, 7, OrderKind::tare, OrderResult::waiting};
  log.told(now);
  now.last_orders[0].result = OrderResult::not_kept;
  EXPECT_EQ(log.told(now), "info order 1 (the PLC's 7), tare: not_kept\n");
  EXPECT_EQ(log.told(now), "");
  now.last_orders[1] = now.last_orders[0];
  now.last_orders[0] = {2, 8, OrderKind::length, OrderResult::refused};
  now.last_orders[1].result = OrderResult::done;
  EXPECT_EQ(log.told(now), "info order 1 (the PLC's 7), tare: done\ninfo order 2 (the PLC's 8), length: refused\n");
  now.last_orders[2] = now.last_orders[1];
  now.last_orders[1] = now.last_orders[0];
  now.last_orders[0] = {3, 8, OrderKind::length, OrderResult::refused};
  EXPECT_EQ(log.told(now), "info order 3 (the PLC's 8), length: refused\n") << "the same once more is another";
}

TEST(EventLogLines, missed_cycles_are_counted_from_the_cycle_before) {
  Log log;
  Snapshot now;
  now.overruns = 5;
  EXPECT_EQ(log.told(now).find("missed"), std::string::npos) << "those were missed before anybody listened";
  now.overruns = 8;
  EXPECT_EQ(log.told(now), "warning 3 cycles missed, 8 since the start\n");
  EXPECT_EQ(log.told(now), "");
}

TEST(EventLogLines, a_trial_begins_and_ends) {
  Log log;
  Snapshot now;
  log.told(now);
  now.compensation.trial_left_s = 0.25;
  EXPECT_EQ(log.told(now), "warning compensation: a trial has begun, the value is no prediction\n");
  EXPECT_EQ(log.told(now), "");
  now.compensation.trial_left_s = 0.0;
  EXPECT_EQ(log.told(now), "warning compensation: the trial has ended, the value goes back\n");
}

TEST(EventLogLines, a_clock_is_set_where_it_moves_by_a_second_or_more_against_the_one_that_nobody_sets) {
  // Numbers that a double holds, so that a second is one to the bit.
  Log log;
  EXPECT_EQ(log.told_of_clock(1024.0, 0), "") << "where it stands at first is nobody's doing";
  EXPECT_EQ(log.told_of_clock(1024.875, 0), "");
  const std::string tail = ": times of the log and of histories jump, no prediction does\n";
  const std::string set = "warning the clock on the wall was set ";
  EXPECT_EQ(log.told_of_clock(1025.0, 0), set + "forward by 1 s" + tail);
  EXPECT_EQ(log.told_of_clock(1024.125, 0), "") << "counted from where it was set to";
  EXPECT_EQ(log.told_of_clock(1024.0, 0), set + "back by 1 s" + tail);
  EXPECT_EQ(log.told_of_clock(1124.0, 100 * s_ns), "") << "both have gone on";
}

TEST(EventLogLines, of_a_clock_that_is_set_all_the_time_six_lines_a_minute) {
  Log log;
  int said = 0;
  log.told_of_clock(0.0, 0);
  for (int n = 1; n <= 30; ++n) said += log.told_of_clock(n % 2 == 0 ? 0.0 : 5000.0, n * s_ns).empty() ? 0 : 1;
  EXPECT_EQ(said, 6);
}

TEST(EventLogLines, of_trials_twenty_lines_a_minute) {
  const Logged lines;
  EventLog events(tests::small_network());
  Snapshot now;
  for (int n = 0; n < 60; ++n) {
    now.compensation.trial_left_s = n % 2 == 0 ? 1.0 : 0.0;
    events.note(now, s_ns);
  }
  int said = 0;
  const std::string text = lines.text();
  for (std::size_t at = 0; (at = text.find("compensation:", at)) != std::string::npos; ++at) ++said;
  EXPECT_EQ(said, 20);
}

/// Of each kind so many lines at once, and so many again once a minute has passed, whichever minute.
TEST(EventLogLines, each_kind_has_so_many_lines_a_minute_and_as_many_in_the_next) {
  struct Kind {
    const char* line;
    int most;
    std::function<void(int, Snapshot&)> change;
  };
  const std::vector<Kind> kinds{
      {"info state", 10, [](int n, Snapshot& now) { now.state = n % 2 == 0 ? State::running : State::degraded; }},
      {"warning fault", 5, [](int n, Snapshot& now) { now.fault = n % 2 == 0 ? bits(Fault::history_lost) : 0; }},
      {"warning sensor", 8,
       [](int n, Snapshot& now) { now.sensor_health[1].state = n % 2 == 0 ? SensorState::failed : SensorState::good; }},
      {"info order", 20,
       [](int n, Snapshot& now) {
         now.last_orders[0] = {static_cast<std::uint32_t>(n + 1), 1, OrderKind::tare, OrderResult::done};
       }},
      {"warning 1 cycles missed", 1, [](int, Snapshot& now) { ++now.overruns; }},
      {"warning compensation: a trial", 10,
       [](int n, Snapshot& now) { now.compensation.trial_left_s = n % 2 == 0 ? 1.0 : 0.0; }}};
  for (const Kind& kind : kinds) {
    EventLog events(tests::small_network());
    Snapshot now;
    events.note(now, 0);
    for (const std::int64_t second : {100, 159, 160}) {
      const Logged lines;
      for (int n = 0; n < 60; ++n) {
        kind.change(n + static_cast<int>(second) * 60, now);
        events.note(now, second * s_ns);
      }
      const std::string text = lines.text();
      int said = 0;
      for (std::size_t at = 0; (at = text.find(kind.line, at)) != std::string::npos; ++at) ++said;
      EXPECT_EQ(said, second == 159 ? 0 : kind.most) << kind.line << " at " << second << " s\n" << text;
    }
  }
}

}  // namespace keep_event_log_test
}  // namespace spindle_twin::firmware
