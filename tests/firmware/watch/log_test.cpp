#include "firmware/watch/log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <regex>
#include <string>
#include <thread>

#include "firmware/keep/event_log.hpp"
#include "firmware/watch/log_limit.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace watch_log_test {

/// The tests' own logger comes back. As the program does, they ignore SIGPIPE: a line that waits for a reader is still
/// written when the test closes its pipe.
struct KeepLogger {
  KeepLogger() { std::signal(SIGPIPE, SIG_IGN); }
  KeepLogger(const KeepLogger&) = delete;
  KeepLogger& operator=(const KeepLogger&) = delete;
  std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
  ~KeepLogger() { spdlog::set_default_logger(before); }
};

struct Pipe {
  Pipe() { EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0); }
  ~Pipe() {
    for (const int end : ends) {
      if (end >= 0) close(end);
    }
  }
  std::string read_all() {
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = read(ends[0], part.data(), part.size())) > 0;) {
      text.append(part.data(), static_cast<std::size_t>(got));
    }
    return text;
  }
  std::array<int, 2> ends{};
};

TEST(Log, lines_of_a_thread_begin_with_the_name_that_it_was_given) {
  const KeepLogger keep;
  Pipe pipe;
  std::atomic<std::uint64_t> dropped{0};
  {
    const Log log("info", pipe.ends[1], dropped);
    const LogName left("left");
    std::thread([] {
      const LogName right("right");
      {
        const LogName inner("inner");
        spdlog::info("a");
      }
      spdlog::warn("b");
    }).join();
    spdlog::info("c");
    std::thread([] { spdlog::info("d"); }).join();
  }
  const std::string text = pipe.read_all();
  for (const char* line : {" info inner: a\n", " warning right: b\n", " info left: c\n", " info d\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << text;
  }
}

TEST(Log, writes_what_is_said_at_its_level) {
  const KeepLogger keep;
  Pipe pipe;
  std::atomic<std::uint64_t> dropped{0};
  {
    const Log log("info", pipe.ends[1], dropped);
    spdlog::info("one {}", 1);
    spdlog::debug("not this");
  }
  const std::string text = pipe.read_all();
  EXPECT_NE(text.find(" info one 1\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("not this"), std::string::npos);
  EXPECT_EQ(text.find("dropped"), std::string::npos);
  EXPECT_EQ(dropped.load(), 0U);
}

TEST(Log, a_line_of_any_length_comes_whole) {
  const KeepLogger keep;
  Pipe pipe;
  std::atomic<std::uint64_t> dropped{0};
  for (const std::size_t bytes : {4000U, 4096U, 5000U, 20000U}) {
    {
      const Log log("info", pipe.ends[1], dropped);
      spdlog::info("{}!", std::string(bytes, 'x'));
      spdlog::info("next");
    }
    EXPECT_NE(pipe.read_all().find(" info " + std::string(bytes, 'x') + "!\n"), std::string::npos) << bytes;
  }
}

/// The sum of all numbers: a thread that writes late has taken its first line between two that were dropped.
std::uint64_t lines_said_to_be_dropped(const std::string& text) {
  static const std::regex said("\\(([0-9]+) lines of the log were dropped here\\)\n");
  std::uint64_t sum = 0;
  for (std::sregex_iterator each(text.begin(), text.end(), said), end; each != end; ++each) {
    sum += std::stoull((*each)[1]);
  }
  return sum;
}

/// Of a pipe that nobody has read: one line is being written, so many wait, and how many do not is said between them.
TEST(Log, so_many_lines_wait_as_there_is_room_for_and_what_was_dropped_is_said_in_its_place) {
  for (const std::uint64_t too_many : {std::uint64_t{1}, std::uint64_t{3}}) {
    const KeepLogger keep;
    Pipe pipe;
    fcntl(pipe.ends[1], F_SETFL, O_NONBLOCK);
    while (write(pipe.ends[1], "", 1) == 1) {
    }
    fcntl(pipe.ends[1], F_SETFL, 0);
    std::atomic<std::uint64_t> dropped{0};
    int said = 0;
    std::string text;
    {
      const Log log("info", pipe.ends[1], dropped, 2);
      for (; dropped < too_many && said < 20; ++said) {
        spdlog::info("line");
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
      text += pipe.read_all();
    }
    text += pipe.read_all();
    EXPECT_EQ(dropped.load(), too_many);
    EXPECT_LE(said, 3 + static_cast<int>(too_many)) << "one in the making and two that wait";
    EXPECT_EQ(lines_said_to_be_dropped(text), too_many) << text;
  }
}

TEST(Log, lines_for_the_journal_carry_their_severity_and_no_time) {
  const KeepLogger keep;
  Pipe pipe;
  struct stat status {};
  ASSERT_EQ(fstat(pipe.ends[1], &status), 0);
  std::atomic<std::uint64_t> dropped{0};
  for (const bool journal : {true, false}) {
    const std::string stream = std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino + (journal ? 0 : 1));
    ::setenv("JOURNAL_STREAM", stream.c_str(), 1);
    {
      const Log log("debug", pipe.ends[1], dropped);
      spdlog::debug("a");
      spdlog::info("b");
      spdlog::warn("c");
      spdlog::error("d");
    }
    ::unsetenv("JOURNAL_STREAM");
    const std::string text = pipe.read_all();
    if (journal) {
      EXPECT_EQ(text, "<7>a\n<6>b\n<4>c\n<3>d\n");
    } else {
      EXPECT_EQ(text.find('<'), std::string::npos) << text;
    }
  }
}

TEST(Log, nobody_waits_for_a_reader_and_what_is_dropped_is_counted) {
  const KeepLogger keep;
  Pipe pipe;
  std::atomic<std::uint64_t> dropped{0};
  {
    const Log log("info", pipe.ends[1], dropped, 100);
    const std::string line(1000, 'x');
    for (int i = 0; i < 1000; ++i) spdlog::info("{}", line);  // a pipe holds 64 KiB
    EXPECT_GT(dropped.load(), 700U);
    EXPECT_LT(dropped.load(), 1000U);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_FALSE(pipe.read_all().empty());
}

TEST(Log, a_reader_that_has_gone_ends_nothing) {
  const KeepLogger keep;
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  Pipe pipe;
  close(pipe.ends[0]);
  pipe.ends[0] = -1;
  std::atomic<std::uint64_t> dropped{0};
  {
    const Log log("info", pipe.ends[1], dropped);
    spdlog::info("to nobody");
    for (std::uint64_t lines = 1; lines <= 3; ++lines) {
      for (int i = 0; i < 1000 && dropped.load() < lines; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      EXPECT_EQ(dropped.load(), lines);
      if (lines < 3) spdlog::info("to nobody");
    }
  }
  std::signal(SIGPIPE, before);
}

/// How often `words` stand in a log.
int lines_with(const std::string& text, const std::string& words) {
  int found = 0;
  for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at) ++found;
  return found;
}

TEST(LogLimit, lets_a_few_pass_each_minute_and_counts_the_others) {
  LogLimit limit(2, 60.0);
  constexpr std::int64_t s = 1'000'000'000;
  EXPECT_EQ(limit.pass(1 * s), 0U);
  EXPECT_EQ(limit.pass(2 * s), 0U);
  for (int i = 0; i < 900; ++i) EXPECT_FALSE(limit.pass(3 * s).has_value());
  EXPECT_EQ(limit.pass(62 * s), 900U);
  EXPECT_EQ(LogLimit::also(0), "");
  EXPECT_EQ(LogLimit::also(900), " (and 900 times that were not logged)");
}

/// What an EventLog writes at level info while `work` tells it of cycles.
std::string log_of(const std::function<void(EventLog&)>& work) {
  const KeepLogger keep;
  Pipe pipe;
  std::atomic<std::uint64_t> dropped{0};
  {
    const Log log("info", pipe.ends[1], dropped);
    EventLog events(tests::small_network());
    work(events);
  }
  return pipe.read_all();
}

TEST(EventLog, one_line_per_event_and_none_per_cycle) {
  const std::string text = log_of([](EventLog& events) {
    Snapshot now;
    std::int64_t time_ns = 0;
    const auto cycles = [&](int count) {
      for (int i = 0; i < count; ++i) events.note(now, time_ns += 1'000'000'000);
    };
    now.state = State::running;
    cycles(10);
    now.sensor_health[1] = {SensorState::failed, SensorFault::drift};
    now.state = State::degraded;
    now.quality = bits(Quality::sensor_failed);
    now.fault = bits(Fault::output_clamped);
    now.last_orders[0] = {3, 4711, OrderKind::tare, OrderResult::waiting};
    cycles(10);
    now.last_orders[0].result = OrderResult::done;
    now.sensor_health[1].state = SensorState::returning;
    cycles(10);
    now.sensor_health[1] = {};
    now.fault = 0;
    now.overruns = 4;
    cycles(10);
    for (int i = 0; i < 1000; ++i) {
      now.state = i % 2 == 0 ? State::running : State::degraded;
      events.note(now, time_ns);
    }
  });
  const auto count = [&](const std::string& line) { return lines_with(text, line); };
  EXPECT_EQ(count("state degraded, quality: sensor_failed"), 1 + 4) << text;
  EXPECT_EQ(count("sensor sleeve_middle: failed, drift"), 1);
  EXPECT_EQ(count("sensor sleeve_middle: believed again"), 1);
  EXPECT_EQ(count("fault output_clamped\n"), 1);
  EXPECT_EQ(count("fault output_clamped is over"), 1);
  EXPECT_EQ(count("order 3 (the PLC's 4711), tare: done"), 1);
  EXPECT_EQ(count("4 cycles missed, 4 since the start"), 1);
  EXPECT_LE(count("state "), 10) << "flapping is held back";
}

TEST(EventLog, of_each_cause_so_many_lines_a_minute_and_the_next_minute_says_how_many_were_left_out) {
  const std::string text = log_of([](EventLog& events) {
    Snapshot now;
    const auto flap = [&](std::uint32_t n, std::int64_t time_ns) {
      const bool up = n % 2 == 1;
      now.state = up ? State::degraded : State::running;
      now.fault = up ? bits(Fault::output_clamped) : std::uint16_t{0};
      now.sensor_health[1].state = up ? SensorState::failed : SensorState::good;
      now.last_orders[0] = {n, 1, OrderKind::tare, OrderResult::done};
      now.overruns += 1;
      events.note(now, time_ns);
    };
    constexpr std::int64_t began_ns = 5'000'000'000, minute_ns = 60'000'000'000;
    for (std::uint32_t n = 1; n <= 100; ++n) flap(n, began_ns);
    flap(101, began_ns + minute_ns - 1);
    flap(102, began_ns + minute_ns);
  });
  const auto lines = [&](const char* of) { return lines_with(text, of); };
  // Each once more in the second minute; the first cycle has no sensor of before and misses none.
  EXPECT_EQ(lines(" state "), 10 + 1) << text;
  EXPECT_EQ(lines(" fault "), 10 + 1);
  EXPECT_EQ(lines(" sensor "), 16 + 1);
  EXPECT_EQ(lines(" order "), 20 + 1);
  EXPECT_EQ(lines("cycles missed"), 1 + 1);
  EXPECT_EQ(lines("(and 91 times that were not logged)"), 2) << "state and fault: 101 of which 10 were said";
  EXPECT_EQ(lines("(and 85 times that were not logged)"), 1);
  EXPECT_EQ(lines("(and 81 times that were not logged)"), 1);
  EXPECT_EQ(lines("(and 99 times that were not logged)"), 1);
}

TEST(EventLog, a_trial_lasts_to_its_last_moment) {
  const std::string text = log_of([](EventLog& events) {
    Snapshot now;
    std::int64_t time_ns = 0;
    for (const double left_s : {0.0, 1.5, 0.5, 1.5, 0.0}) {
      now.compensation.trial_left_s = left_s;
      events.note(now, time_ns += 1'000'000'000);
    }
  });
  EXPECT_EQ(lines_with(text, "a trial has begun"), 1) << text;
  EXPECT_EQ(lines_with(text, "the trial has ended"), 1) << text;
}

TEST(EventLog, a_clock_that_is_set_is_said_and_one_that_is_steered_is_not) {
  const std::string text = log_of([](EventLog& events) {
    constexpr std::int64_t s_ns = 1'000'000'000;
    double unix_s = 1.7e9;
    for (int n = 0; n < 100; ++n) events.note_clock(unix_s += 1.001, n * s_ns);  // by a millisecond a second
    unix_s += 3600.0;
    events.note_clock(unix_s += 1.0, 100 * s_ns);
    events.note_clock(unix_s += 1.0, 101 * s_ns);
    unix_s -= 86400.0;
    events.note_clock(unix_s += 1.0, 102 * s_ns);
  });
  EXPECT_EQ(lines_with(text, "the clock on the wall was set forward by 3600 s"), 1) << text;
  EXPECT_EQ(lines_with(text, "the clock on the wall was set back by 86400 s"), 1);
  EXPECT_EQ(lines_with(text, "the clock on the wall"), 2);
}

}  // namespace watch_log_test
}  // namespace spindle_twin::firmware
