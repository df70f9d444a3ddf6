#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <list>
#include <string>
#include <thread>

#include "firmware/serve/modbus_server.hpp"
#include "tests/firmware/support/http_serving.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/no_descriptors.hpp"
#include "tests/firmware/support/serving.hpp"
#include "tests/firmware/support/standing_clock.hpp"
#include "tests/firmware/support/troubled_poll.hpp"

/// How long the Modbus server waits for what, on a clock that stands.
namespace spindle_twin::firmware {
namespace serve_modbus_patience_test {

using namespace serving;
/// One that may stay silent, break off, and have an address of its own.
using Other = http_serving::Client;

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

template <class TheClock>
struct Patient {
  explicit Patient(const ServePlan& plan = Serving::plan())
      : server(plan, clock, {{units_of_one_spindle(), snapshots, signals, orders}}),
        thread([this] { server.run(); }),
        asks(server.port()) {
    look();
  }
  ~Patient() {
    server.stop();
    thread.join();
  }
  Patient(const Patient&) = delete;
  Patient& operator=(const Patient&) = delete;

  /// The server has looked twice at all that was there before: what it accepts, it looks at in its next turn.
  void look() {
    for (int n = 0; n < 2; ++n) EXPECT_EQ(payload(asks.ask(read_known)), known_words);
  }
  bool sleeps() {
    long before = -1;
    for (int n = 0; n < 20 && before != clock.asked; ++n) {
      before = clock.asked;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return before == clock.asked;
  }

  TheClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ModbusServer server;
  std::thread thread;
  serving::Client asks;
};
using Standing = Patient<StandingClock>;

TEST(ModbusPatience, a_frame_has_its_time_from_the_first_byte_to_the_last_also_behind_an_answer) {
  Standing standing;
  Other slow(standing.server.port());
  const std::string frame = text_of(serving::Client::framed(read_known));
  slow.send(frame);
  EXPECT_NE(slow.read_until(std::string("\xC1\x48", 2)), "");
  EXPECT_NE(slow.read_until(std::string("\xC1\x48", 2)), "");
  slow.send(frame.substr(0, 1));
  standing.look();
  standing.clock.pass(ns_per_s / 10);
  slow.send(frame.substr(1, 7));  // does not begin it anew
  standing.look();
  standing.clock.pass(ns_per_s / 5 - 1);
  standing.look();
  EXPECT_TRUE(slow.hears_nothing());
  standing.clock.pass(1);
  standing.look();
  EXPECT_TRUE(slow.is_ended());
}

TEST(ModbusPatience, a_connection_may_be_idle_for_as_long_as_the_plan_says) {
  Standing standing;
  Other idle(standing.server.port());
  standing.look();
  standing.clock.pass(300 * ns_per_s - 1);
  standing.look();
  EXPECT_TRUE(idle.hears_nothing());
  standing.clock.pass(1);
  standing.look();
  EXPECT_TRUE(idle.is_ended());
}

TEST(ModbusPatience, who_ends_its_side_within_a_frame_is_ended_though_the_clock_stands) {
  Standing standing;
  Other half(standing.server.port());
  half.send(text_of(serving::Client::framed(read_known)).substr(0, 8));
  standing.look();
  EXPECT_TRUE(half.hears_nothing());
  half.end_sending();
  EXPECT_TRUE(half.is_ended());
}

/// Nothing else happens: only its own wait can wake it.
TEST(ModbusPatience, deadlines_are_kept_by_a_server_that_nobody_asks) {
  ServePlan plan = Serving::plan();
  plan.frame_deadline_s = 0.02;
  {
    const Serving serving(plan);
    Other slow(serving.server.port());
    slow.send("\x01");
    const Other idle(serving.server.port());
    EXPECT_TRUE(slow.is_ended());
  }
  plan.idle_s = 0.02;
  const Serving serving(plan);
  Other idle(serving.server.port());
  EXPECT_TRUE(idle.is_ended());
}

TEST(ModbusPatience, it_sleeps_while_nobody_asks_whoever_is_there) {
  Standing standing;
  EXPECT_TRUE(standing.sleeps());
  const Other idle(standing.server.port());
  Other half(standing.server.port());
  half.send(text_of(serving::Client::framed(read_known)).substr(0, 8));
  standing.look();
  EXPECT_TRUE(standing.sleeps());
}

TEST(ModbusPatience, who_has_been_idle_for_five_seconds_makes_room_and_nobody_before) {
  ServePlan plan = Serving::plan();
  plan.connections = 2;
  Standing standing(plan);
  Other idle(standing.server.port());
  standing.look();
  standing.clock.pass(5 * ns_per_s - 1);
  standing.look();
  Other refused(standing.server.port());
  EXPECT_TRUE(refused.is_ended());
  standing.clock.pass(1);
  standing.look();
  Other taken(standing.server.port());
  EXPECT_TRUE(idle.is_ended());
  EXPECT_TRUE(taken.hears_nothing());
}

/// Another's connection is left alone, though it is idle for longer.
TEST(ModbusPatience, an_address_that_has_its_share_makes_room_for_itself) {
  ServePlan plan = Serving::plan();
  plan.connections_per_host = 1;
  Standing standing(plan);
  Other elsewhere(standing.server.port(), INADDR_LOOPBACK + 1);
  standing.look();
  standing.clock.pass(ns_per_s);
  Other first(standing.server.port(), INADDR_LOOPBACK + 2);
  standing.look();
  standing.clock.pass(5 * ns_per_s);
  Other second(standing.server.port(), INADDR_LOOPBACK + 2);
  EXPECT_TRUE(first.is_ended());
  EXPECT_TRUE(second.hears_nothing());
  EXPECT_TRUE(elsewhere.hears_nothing());
}

TEST(ModbusPatience, without_a_descriptor_nobody_is_accepted_for_a_second_and_then_who_has_waited) {
  const Logged log;
  Standing standing;
  Other next(0);  // has its descriptor, and no connection yet
  {
    const NoDescriptors none;
    next.connect(standing.server.port());
    // A busy kernel brings the connection some turns later.
    for (int n = 0; n < 1000 && log.text().empty(); ++n) standing.look();
  }
  EXPECT_NE(log.text().find("error server: no client can be accepted: Too many open files\n"), std::string::npos);
  next.send(text_of(serving::Client::framed(read_known)));
  standing.clock.pass(ns_per_s - 1);
  standing.look();
  EXPECT_TRUE(next.hears_nothing());
  standing.clock.pass(1);
  standing.look();
  EXPECT_NE(next.read_until(std::string("\xC1\x48", 2)), "");
}

TEST(ModbusPatience, behind_a_poll_that_failed_it_rests_a_tenth_of_a_second_and_says_so) {
  const Logged log;
  RestingClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ModbusServer server(Serving::plan(), clock, {{units_of_one_spindle(), snapshots, signals, orders}});
  std::thread thread([&] { server.run(); });
  serving::Client client(server.port());
  EXPECT_EQ(payload(client.ask(read_known)), known_words);
  {
    const NoPoll none;
    client.send(serving::Client::framed(read_known));  // the next poll fails, or the one behind this question
    clock.wait_until_it_rests();
  }
  clock.wake();
  EXPECT_EQ(clock.rest_ns, ns_per_s / 10);
  EXPECT_EQ(payload(client.receive()), known_words);
  server.stop();
  thread.join();
  EXPECT_NE(log.text().find("error server: poll: Invalid argument\n"), std::string::npos) << log.text();
}

TEST(ModbusPatience, a_signal_ends_neither_it_nor_is_it_an_error) {
  const Interruption quiet;
  const Logged log;
  {
    Standing standing;
    for (int n = 0; n < 20; ++n) {
      Interruption::of(standing.thread);
      standing.look();
    }
  }
  EXPECT_EQ(log.text(), "");
}

/// Two that are closed for it leave the lowest two free, for the client and for the server's end of it.
TEST(ModbusPatience, eight_descriptors_are_kept_for_files) {
  const Logged log;
  const Standing standing;
  std::list<serving::Client> clients;  // kept, so that no descriptor is given back meanwhile
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  for (const int left : {9, 8}) {
    const int one = ::dup(0), other = ::dup(0);
    ::close(one), ::close(other);
    ASSERT_LT(one, other);
    const rlimit little{static_cast<rlim_t>(other + left), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &little), 0);
    serving::Client& client = clients.emplace_back(standing.server.port());
    if (left == 9) {
      EXPECT_EQ(payload(client.ask(read_known)), known_words);
    } else {
      EXPECT_TRUE(client.closed_by_server());
      EXPECT_NE(log.text().find("the last file descriptors are kept"), std::string::npos) << log.text();
    }
    setrlimit(RLIMIT_NOFILE, &before);
  }
}

TEST(ModbusPatience, a_server_behind_tls_alone_has_no_port) {
  ServePlan plan = Serving::plan();
  plan.plain = false;
  MonotonicClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  const ModbusServer server(plan, clock, {{units_of_one_spindle(), snapshots, signals, orders}});
  EXPECT_EQ(server.port(), 0);
}

}  // namespace serve_modbus_patience_test
}  // namespace spindle_twin::firmware
