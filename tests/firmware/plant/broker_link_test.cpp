#include "firmware/plant/broker_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "firmware/plant/payload.hpp"
#include "firmware/watch/clock.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/small_broker.hpp"
#include "tests/firmware/support/small_network.hpp"

/// One thread: the link and the broker take their turns, at the time that a test says.
namespace spindle_twin::firmware {
namespace plant_broker_link_test {

using small_broker::Broker;
using small_broker::Bytes;
using small_broker::comes_true;
using small_broker::metric_ms;

class PlantLink : public ::testing::Test {
 protected:
  PlantLink() { plan_.port = broker_.port(); }

  static EdgeNode one_device(std::size_t queue) {
    std::vector<PlantDevice> devices;
    devices.push_back(
        {"a", std::make_unique<PlantMetrics>(names_of(tests::small_network()), std::vector<std::string>{"nose"})});
    return {"group", "node", std::move(devices), queue};
  }
  void turn() {
    link_.step(now_);
    broker_.turn();
  }
  /// For so long that what was sent comes.
  void turns() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(3);
    while (std::chrono::steady_clock::now() < end) turn();
  }
  template <class Done>
  bool turns_until(Done done) {
    return comes_true([&] {
      turn();
      return done();
    });
  }
  /// Whether the broker comes to hear so many messages of this kind, and no more.
  bool hears(const char* kind, std::size_t wanted) {
    turns_until([&] { return broker_.count(kind) >= wanted; });
    turns();
    return broker_.count(kind) == wanted;
  }
  bool comes_to_publish(std::uint64_t wanted) {
    turns_until([&] { return counts_.published >= wanted; });
    return counts_.published == wanted;
  }
  bool comes_to_await(std::size_t answers) {
    return turns_until([&] { return broker_.unconfirmed() == answers; });
  }
  /// Up to the answer to its subscription, if the broker gives one.
  bool connects() {
    const std::size_t before = broker_.count("NBIRTH");
    if (!turns_until([&] { return link_.connected() && broker_.count("NBIRTH") > before; })) return false;
    turns();
    return true;
  }
  void pass(std::int64_t ns) {
    now_.ns += ns;
    now_.ms += static_cast<std::uint64_t>(ns / 1'000'000);
  }
  void add(std::uint64_t time_ms) { node_.add(0, time_ms, {{1.0}, {MetricQuality::good}}); }
  /// Until the next attempt, which it makes.
  void wait_for_attempt() {
    now_.ns = link_.due_ns();
    const int before = broker_.connections;
    turns_until([&] { return broker_.connections > before; });
  }
  bool is_lost() {
    return turns_until([&] { return !link_.connected() && link_.waits_for().fd == -1; });
  }

  const Logged log_;
  Broker broker_;
  PlantPlan plan_{.enabled = true, .host = "127.0.0.1", .group = "group", .node = "node"};
  EdgeNode node_ = one_device(3);
  PlantCounts counts_;
  PlantTime now_{1000 * ns_per_s, 1'700'000'000'000};
  BrokerLink link_{plan_, node_, counts_};
};

TEST_F(PlantLink, greets_with_its_will_its_subscription_and_its_birth) {
  EXPECT_EQ(link_.waits_for().fd, -1);
  EXPECT_EQ(counts_.connected, 0U);
  ASSERT_TRUE(connects());
  EXPECT_EQ(counts_.connected, 1U);
  EXPECT_GE(link_.waits_for().fd, 0);
  EXPECT_EQ(link_.waits_for().events, POLLIN) << "nothing is left to send";
  EXPECT_EQ(link_.due_ns(), now_.ns + ns_per_s / 2);
  // Protocol 5; clean start, a will of quality of service 1 that is not retained; keep-alive in s.
  EXPECT_EQ(Bytes(broker_.connect.begin(), broker_.connect.begin() + 10),
            (Bytes{0, 4, 'M', 'Q', 'T', 'T', 5, 0b0000'1110, 0, 30}));
  EXPECT_EQ(broker_.subscribed, std::vector<std::string>{"spBv1.0/group/NCMD/node 1"});
  ASSERT_EQ(broker_.published.size(), 1U);
  EXPECT_EQ(broker_.published[0].topic, "spBv1.0/group/NBIRTH/node");
}

TEST_F(PlantLink, a_sample_is_under_way_until_the_broker_has_answered_the_subscription_behind_it) {
  ASSERT_TRUE(connects());
  broker_.confirms = false;
  add(1);
  EXPECT_TRUE(hears("DDATA", 1));
  ASSERT_TRUE(comes_to_await(1));
  EXPECT_EQ(counts_.published, 0U);
  EXPECT_EQ(counts_.waiting, 1U);
  add(2);
  turns();
  EXPECT_EQ(broker_.count("DDATA"), 1U) << "the one before is under way";
  EXPECT_EQ(counts_.waiting, 2U);
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(1));
  EXPECT_TRUE(hears("DDATA", 2));
  ASSERT_TRUE(comes_to_await(1));
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(2));
  turns();
  EXPECT_EQ(counts_.waiting, 0U);
  EXPECT_EQ(broker_.unconfirmed(), 0U) << "without data nothing is asked";
  EXPECT_EQ(broker_.subscribed.size(), 3U);
}

TEST_F(PlantLink, an_answer_to_another_question_confirms_nothing) {
  ASSERT_TRUE(connects());
  broker_.confirms = false;
  add(1);
  ASSERT_TRUE(comes_to_await(1));
  broker_.send({0x90, 4, 0x7F, 0x7F, 0, 0});
  turns();
  EXPECT_EQ(counts_.published, 0U);
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(1));
}

TEST_F(PlantLink, the_broker_has_half_a_minute_to_answer_and_then_all_is_said_again) {
  ASSERT_TRUE(connects());
  broker_.confirms = false;
  add(7);
  ASSERT_TRUE(comes_to_await(1));
  pass(30 * ns_per_s);
  turns();
  EXPECT_TRUE(link_.connected());
  pass(1);
  EXPECT_TRUE(is_lost());
  EXPECT_NE(log_.text().find("plant: connection lost to 127.0.0.1:"), std::string::npos) << log_.text();
  EXPECT_NE(log_.text().find("the broker does not answer; tried again, samples wait\n"), std::string::npos);
  EXPECT_EQ(counts_.connected, 0U);
  EXPECT_EQ(counts_.published, 0U);
  broker_.take_published();
  broker_.confirms = true;
  wait_for_attempt();
  ASSERT_TRUE(connects());
  EXPECT_TRUE(comes_to_publish(1));
  ASSERT_TRUE(hears("DDATA", 1));
  EXPECT_EQ(metric_ms(broker_.published.back().payload), 7U);
}

TEST_F(PlantLink, who_connects_and_hears_nothing_waits_half_a_minute) {
  broker_.accepts = false;
  turns_until([&] { return broker_.connections == 1; });
  pass(30 * ns_per_s);
  turns();
  EXPECT_GE(link_.waits_for().fd, 0);
  pass(1);
  EXPECT_TRUE(is_lost());
  EXPECT_NE(log_.text().find("plant: no connection to 127.0.0.1:"), std::string::npos) << log_.text();
  EXPECT_NE(log_.text().find(": no answer; tried again"), std::string::npos) << log_.text();
}

TEST_F(PlantLink, each_failure_doubles_the_wait_up_to_half_a_minute_and_chance_takes_half_of_it_at_most) {
  broker_.accepts = false;
  for (const double wait_s : {1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0}) {
    wait_for_attempt();
    turns_until([&] { return !broker_.connect.empty(); });
    broker_.connect.clear();
    broker_.end();
    ASSERT_TRUE(is_lost());
    const double waits_s = 1e-9 * static_cast<double>(link_.due_ns() - now_.ns);
    EXPECT_GE(waits_s, 0.5 * wait_s);
    EXPECT_LE(waits_s, wait_s);
    const int before = broker_.connections;
    now_.ns = link_.due_ns() - 1;
    turns();
    EXPECT_EQ(broker_.connections, before) << "not before it is due";
  }
  const std::string text = log_.text();
  EXPECT_EQ(text.find("no connection to"), text.rfind("no connection to")) << "said once: " << text;
}

TEST_F(PlantLink, a_connection_that_held_more_than_ten_seconds_is_tried_again_soon) {
  const auto waits_after = [&](std::int64_t held_ns) {
    EXPECT_TRUE(connects());
    pass(held_ns);
    broker_.end();
    EXPECT_TRUE(is_lost());
    const double waits_s = 1e-9 * static_cast<double>(link_.due_ns() - now_.ns);
    wait_for_attempt();
    return waits_s;
  };
  EXPECT_LE(waits_after(0), 1.0);
  EXPECT_GE(waits_after(10 * ns_per_s), 1.0) << "of at most 2 s";
  EXPECT_GE(waits_after(10 * ns_per_s), 2.0) << "of at most 4 s";
  EXPECT_LE(waits_after(10 * ns_per_s + 1), 1.0);
  EXPECT_GE(waits_after(0), 1.0);
}

/// An order for births, made longer by a field that nobody knows.
Bytes rebirth_order(std::size_t bytes) {
  PayloadMessage message{5};
  message.metrics.push_back({.name = "Node Control/Rebirth", .type = DataType::boolean, .value = 1.0});
  Bytes order = encode_payload(message);
  if (bytes <= order.size()) return order;
  const std::size_t rest = bytes - order.size() - 4;  // tag 15 with a length of three bytes
  order.push_back(15 << 3 | 2);
  for (const std::size_t part : {rest % 128 + 128, rest / 128 % 128 + 128, rest / 16384}) {
    order.push_back(static_cast<std::uint8_t>(part));
  }
  order.resize(bytes);
  return order;
}

TEST_F(PlantLink, births_are_said_when_asked_for_and_once_a_second_at_most) {
  ASSERT_TRUE(connects());
  EXPECT_EQ(broker_.count("NBIRTH"), 1U);
  const auto ask = [&] {
    broker_.publish(node_.order_topic(), rebirth_order(0));
    turns();
    turns();
  };
  ask();
  EXPECT_EQ(broker_.count("NBIRTH"), 1U) << "a second has not passed";
  pass(ns_per_s - 1);
  turns();
  EXPECT_EQ(broker_.count("NBIRTH"), 1U);
  pass(1);
  EXPECT_TRUE(hears("NBIRTH", 2)) << "asked for before, said now";
  pass(100 * ns_per_s);
  turns();
  EXPECT_EQ(broker_.count("NBIRTH"), 2U) << "who does not ask gets none";
  ask();
  EXPECT_TRUE(hears("NBIRTH", 3));
  broker_.publish(node_.order_topic(), {1, 2, 3});
  pass(2 * ns_per_s);
  turns();
  EXPECT_EQ(broker_.count("NBIRTH"), 3U);
}

TEST_F(PlantLink, an_order_may_have_64_KiB) {
  ASSERT_TRUE(connects());
  for (const auto& [bytes, births] : {std::pair{std::size_t{65536}, std::size_t{2}}, {65537, 2}, {65535, 3}}) {
    pass(ns_per_s);
    ASSERT_EQ(rebirth_order(bytes).size(), bytes);
    broker_.publish(node_.order_topic(), rebirth_order(bytes));
    turns();
    EXPECT_TRUE(hears("NBIRTH", births)) << bytes;
  }
}

TEST_F(PlantLink, a_broker_that_lets_nobody_ask_for_births_still_confirms_and_it_is_said_once) {
  broker_.confirms = false;
  ASSERT_TRUE(connects());
  ASSERT_TRUE(comes_to_await(1));
  broker_.confirm(0x80);  // the least of the codes that refuse
  for (const std::uint64_t sample : {1U, 2U}) {
    add(sample);
    ASSERT_TRUE(comes_to_await(1));
    broker_.confirm(0x87);
    EXPECT_TRUE(comes_to_publish(sample));
  }
  const std::string text = log_.text(), refuses = "the broker refuses spBv1.0/group/NCMD/node";
  EXPECT_NE(text.find(refuses), std::string::npos) << text;
  EXPECT_EQ(text.find(refuses), text.rfind(refuses)) << text;
}

TEST_F(PlantLink, a_broker_that_grants_another_quality_of_service_refuses_nothing) {
  broker_.confirms = false;
  ASSERT_TRUE(connects());
  ASSERT_TRUE(comes_to_await(1));
  broker_.confirm(0x7F);
  add(1);
  ASSERT_TRUE(comes_to_await(1)) << "it is answered";
  EXPECT_EQ(log_.text().find("refuses"), std::string::npos) << log_.text();
}

TEST_F(PlantLink, who_is_refused_says_why) {
  broker_.accepts = false;
  turns_until([&] { return !broker_.connect.empty(); });
  broker_.accept_session(0x87);
  EXPECT_TRUE(is_lost());
  EXPECT_NE(log_.text().find(": refused: Not authorized"), std::string::npos) << log_.text();
}

TEST_F(PlantLink, whom_the_broker_ends_says_why) {
  ASSERT_TRUE(connects());
  broker_.send({0xE0, 2, 0x8B, 0});
  EXPECT_TRUE(is_lost());
  EXPECT_NE(log_.text().find("ended by the broker: Server shutting down"), std::string::npos) << log_.text();
}

TEST_F(PlantLink, what_the_queue_drops_is_said_when_it_begins_and_counted_in_all_when_none_waits) {
  const auto said = [&](const std::string& words) {
    const std::string text = log_.text();
    int found = 0;
    for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  ASSERT_TRUE(connects());
  broker_.confirms = false;
  for (std::uint64_t t = 1; t <= 4; ++t) add(t);  // three wait at most
  turns();
  EXPECT_EQ(counts_.dropped, 1U);
  EXPECT_EQ(said("the queue is full, the oldest samples are dropped"), 1);
  for (std::uint64_t t = 5; t <= 9; ++t) add(t);
  turns();
  EXPECT_EQ(counts_.dropped, 3U);
  EXPECT_EQ(counts_.waiting, 6U) << "three of them under way";
  EXPECT_EQ(said("dropped"), 1);
  ASSERT_TRUE(comes_to_await(1));
  broker_.confirms = true;
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(6));
  EXPECT_EQ(counts_.waiting, 0U);
  EXPECT_EQ(said("3 samples were dropped in all"), 1);
  broker_.confirms = false;
  for (std::uint64_t t = 10; t <= 13; ++t) add(t);
  ASSERT_TRUE(comes_to_await(1));
  EXPECT_EQ(counts_.dropped, 4U);
  EXPECT_EQ(said("the queue is full, the oldest samples are dropped"), 2);
  add(14);
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(9));
  EXPECT_EQ(counts_.waiting, 1U);
  EXPECT_EQ(said("in all"), 1) << "one waits yet";
  ASSERT_TRUE(comes_to_await(1));
  broker_.confirm();
  EXPECT_TRUE(comes_to_publish(10));
  EXPECT_EQ(said("1 samples were dropped in all"), 1);
}

TEST_F(PlantLink, of_a_broker_that_comes_and_goes_three_lines_in_ten_minutes_are_said) {
  for (int n = 0; n < 4; ++n) {
    if (n > 0) wait_for_attempt();
    ASSERT_TRUE(connects());
    broker_.end();
    ASSERT_TRUE(is_lost());
  }
  const std::string text = log_.text();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
  pass(600 * ns_per_s);
  ASSERT_TRUE(connects());
  EXPECT_NE(log_.text().find(" (and 5 times that were not logged)\n"), std::string::npos) << log_.text();
}

TEST_F(PlantLink, who_leaves_has_the_broker_say_its_death) {
  ASSERT_TRUE(connects());
  link_.leave();
  EXPECT_TRUE(comes_true([&] {
    broker_.turn();
    return !broker_.disconnect.empty();
  }));
  EXPECT_EQ(broker_.disconnect[0], 4) << "with the will";
  EXPECT_EQ(counts_.connected, 0U);
  EXPECT_FALSE(link_.connected());
  EXPECT_EQ(link_.waits_for().fd, -1);
}

TEST_F(PlantLink, a_device_that_has_stopped_dies_when_all_that_it_said_has_arrived) {
  ASSERT_TRUE(connects());
  broker_.confirms = false;
  add(1);
  node_.stop(0);
  ASSERT_TRUE(comes_to_await(1));
  EXPECT_EQ(broker_.count("DDEATH"), 0U);
  add(2);
  node_.stop(0);
  broker_.confirms = true;
  broker_.confirm();
  EXPECT_TRUE(hears("DDEATH", 1));
  EXPECT_EQ(broker_.count("DDATA"), 2U);
  EXPECT_EQ(broker_.published.back().topic, "spBv1.0/group/DDEATH/node/a");
}

}  // namespace plant_broker_link_test
}  // namespace spindle_twin::firmware
