#include "firmware/plant/plant_publisher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/plant/payload.hpp"
#include "firmware/watch/clock.hpp"
#include "tests/firmware/support/small_broker.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/firmware/support/standing_clock.hpp"

/// The publisher in its own thread, whose clock stands until a test sets it; its broker in the test's.
namespace spindle_twin::firmware {
namespace plant_publisher_test {

using small_broker::Broker;
using small_broker::Bytes;
using small_broker::comes_true;
using small_broker::metric_ms;
using small_broker::Published;

class Publishes : public ::testing::Test {
 protected:
  Publishes() : publisher_(plan(), {spindle("left", 5.0), spindle("right", 60.0)}, clock_) {
    thread_ = std::thread([this] { publisher_.run(); });
  }
  ~Publishes() override {
    publisher_.stop();
    thread_.join();
  }

  PlantPlan plan() const {
    PlantPlan plan{.enabled = true, .host = "127.0.0.1", .group = "group", .node = "node"};
    plan.port = broker_.port();
    plan.period_s = 10.0;
    plan.registers = {"nose"};
    return plan;
  }
  static SpindleToPublish spindle(const std::string& name, double stale_after_s) {
    return {name, names_of(tests::small_network()), stale_after_s};
  }
  void show_cycle(std::size_t of, std::uint64_t sequence, std::int64_t time_ns) {
    Snapshot snapshot = first_snapshot(tests::small_network());
    snapshot.state = State::running;
    snapshot.sequence = sequence;
    snapshot.time_ns = time_ns;
    snapshot.nose_m = 1e-6;
    publisher_.tap(of).write(snapshot);
  }
  /// An order wakes the publisher, whose clock stands. Not more of them than it reads: what is in the way is lost.
  void wake(const Bytes& order = {}) {
    broker_.publish("spBv1.0/group/NCMD/node", order);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  /// The publisher has seen the time that it is, and what it says has come: it answers an order for births, which are
  /// said once a second at most.
  void see() {
    const std::size_t before = broker_.count("NBIRTH");
    EXPECT_TRUE(comes_true([&] {
      broker_.turn();
      return !broker_.subscribed.empty();  // an order before that would break the protocol
    }));
    EXPECT_TRUE(comes_true([&] {
      if (broker_.count("NBIRTH") == 0 || before > 0) wake(rebirth_);
      broker_.turn();
      return broker_.count("NBIRTH") > before;
    }));
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(3);  // data come behind births
    while (std::chrono::steady_clock::now() < end) broker_.turn();
  }
  /// How many of a kind the broker hears until so long from now.
  std::size_t heard_after(std::int64_t ns, const char* kind) {
    broker_.take_published();
    clock_.pass(ns);
    see();
    return broker_.count(kind);
  }
  std::vector<Published> wait_for(const char* kind, std::size_t count) {
    EXPECT_TRUE(comes_true([&] {
      broker_.turn();
      if (broker_.count(kind) >= count) return true;
      wake();
      return false;
    }));
    std::vector<Published> of_kind;
    for (Published& each : broker_.take_published()) {
      if (each.topic.find(kind) != std::string::npos) of_kind.push_back(std::move(each));
    }
    return of_kind;
  }

  StandingClock clock_;
  Broker broker_;
  PlantPublisher publisher_;
  std::thread thread_;
  const Bytes rebirth_ = [] {
    PayloadMessage message{5};
    message.metrics.push_back({.name = "Node Control/Rebirth", .type = DataType::boolean, .value = 1.0});
    return encode_payload(message);
  }();
};

TEST_F(Publishes, a_cycle_once_and_only_at_each_period) {
  see();
  EXPECT_EQ(broker_.count("DDATA"), 0U) << "there was no cycle";
  const std::int64_t began_ns = clock_.now_ns();
  show_cycle(1, 1, began_ns);
  EXPECT_EQ(heard_after(10 * ns_per_s - 1, "DDATA"), 0U);
  clock_.pass(1);
  const std::vector<Published> first = wait_for("DDATA", 1);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].topic, "spBv1.0/group/DDATA/node/right");
  EXPECT_EQ(heard_after(10 * ns_per_s, "DDATA"), 0U) << "the same cycle";
  show_cycle(1, 2, clock_.now_ns());
  clock_.pass(10 * ns_per_s);
  EXPECT_EQ(wait_for("DDATA", 1).size(), 1U);
  EXPECT_TRUE(comes_true([&] {
    broker_.turn();
    if (publisher_.counts().published == 2) return true;
    wake();
    return false;
  }));
}

TEST_F(Publishes, the_time_of_a_number_is_that_of_its_cycle_by_the_clock_on_the_wall) {
  see();
  for (const std::int64_t age_ns : {std::int64_t{0}, 40 * ns_per_s, -7 * ns_per_s}) {
    clock_.pass(10 * ns_per_s - 1);
    show_cycle(1, static_cast<std::uint64_t>(50 + age_ns / ns_per_s), clock_.now_ns() + 1 - age_ns);
    const double before_ms = 1e3 * unix_now_s();
    clock_.pass(1);
    const std::vector<Published> data = wait_for("DDATA", 1);
    const double after_ms = 1e3 * unix_now_s();
    ASSERT_EQ(data.size(), 1U);
    const auto said_ms = static_cast<double>(metric_ms(data[0].payload));
    const double age_ms = 1e-6 * static_cast<double>(std::max<std::int64_t>(age_ns, 0));
    EXPECT_GE(said_ms, before_ms - age_ms - 2.0) << age_ns;
    EXPECT_LE(said_ms, after_ms - age_ms + 2.0) << age_ns << ": none is of the future";
  }
}

/// The other spindle has a new cycle in each period: when that is heard, this one was looked at.
TEST_F(Publishes, whose_cycle_is_too_old_dies_and_is_born_again_with_the_next) {
  see();
  const std::int64_t period_ns = 10 * ns_per_s;
  std::uint64_t sequence = 0;
  std::vector<std::string> topics;
  const auto heard = [&](const char* kind) {
    const std::string left = std::string("spBv1.0/group/") + kind + "/node/left";
    return std::count(topics.begin(), topics.end(), left);
  };
  const auto listen = [&](auto until) {
    EXPECT_TRUE(comes_true([&] {
      broker_.turn();
      for (Published& each : broker_.take_published()) topics.push_back(std::move(each.topic));
      if (until()) return true;
      wake();
      return false;
    }));
  };
  const auto pass_a_period = [&](std::int64_t age_ns) {
    topics.clear();
    broker_.take_published();
    ++sequence;
    show_cycle(0, sequence, clock_.now_ns() + period_ns - age_ns);
    show_cycle(1, sequence, clock_.now_ns() + period_ns);
    clock_.pass(period_ns);
    listen([&] { return std::find(topics.begin(), topics.end(), "spBv1.0/group/DDATA/node/right") != topics.end(); });
  };
  pass_a_period(5 * ns_per_s);
  EXPECT_EQ(heard("DDATA"), 1) << "as old as it may be";
  pass_a_period(5 * ns_per_s + 1000);
  listen([&] { return heard("DDEATH") == 1; });
  EXPECT_EQ(heard("DDATA"), 0) << "a microsecond too old";
  pass_a_period(5 * ns_per_s + 1000);
  EXPECT_EQ(heard("DDATA") + heard("DDEATH"), 0) << "it is dead";
  pass_a_period(0);
  listen([&] { return heard("DDATA") == 1; });
  EXPECT_EQ(heard("DBIRTH"), 1);
  EXPECT_EQ(heard("DDEATH"), 0);
}

TEST(PlantPublisher, its_only_spindle_needs_no_name) {
  StandingClock clock;
  Broker broker;
  PlantPlan plan{.enabled = true, .host = "127.0.0.1", .group = "group", .node = "node"};
  plan.port = broker.port();
  PlantPublisher publisher(plan, {{"", names_of(tests::small_network())}}, clock);
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.sequence = 1;
  snapshot.time_ns = clock.now_ns() - 5 * ns_per_s;  // no older than it may be
  publisher.tap(0).write(snapshot);
  std::thread thread([&] { publisher.run(); });
  EXPECT_TRUE(comes_true([&] {
    broker.turn();
    return broker.count("DDATA") == 1;
  }));
  publisher.stop();
  thread.join();
  EXPECT_EQ(broker.published.back().topic, "spBv1.0/group/DDATA/node/spindle");
  EXPECT_EQ(publisher.counts().connected, 0U);
  EXPECT_TRUE(comes_true([&] {
    broker.turn();
    return !broker.disconnect.empty();
  }));
}

}  // namespace plant_publisher_test
}  // namespace spindle_twin::firmware
