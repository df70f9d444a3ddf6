#include <gtest/gtest.h>

#include <list>
#include <string>
#include <vector>

#include "firmware/show/http_server.hpp"
#include "tests/firmware/support/http_serving.hpp"

/// Who watches the event stream of HttpServer.
namespace spindle_twin::firmware {
namespace show_http_viewers_test {

using http_serving::Client;
using http_serving::only;
using http_serving::Serving;

/// One that has the head of its stream.
struct Viewer : Client {
  explicit Viewer(const Serving& serving, const std::string& path = "/api/v1/events", int room = 0)
      : Client(serving.server.port(), INADDR_LOOPBACK, room) {
    ask(path);
    EXPECT_TRUE(read_until("\r\n\r\n").starts_with("HTTP/1.1 200 "));
  }
  /// The number of the cycle that the next event is of; waits for it. 0: none came.
  int next_cycle() {
    const std::string event = read_until("\n\n");
    EXPECT_NE(event.find("\nevent: state\ndata: {"), std::string::npos) << event.substr(0, 100);
    return event.starts_with("id: ") ? std::atoi(event.c_str() + 4) : 0;
  }
};

TEST(HttpViewers, an_event_a_second_at_most_of_the_newest_cycle_and_none_without_a_new_one) {
  Serving serving;
  Viewer viewer(serving);
  serving.look();
  EXPECT_TRUE(viewer.hears_nothing()) << "there was no cycle";
  serving.show_cycle(1);
  EXPECT_EQ(viewer.next_cycle(), 1) << "at once, though nothing else happens";
  serving.show_cycle(2);
  serving.pass(ns_per_s - 1);
  EXPECT_TRUE(viewer.hears_nothing());
  serving.show_cycle(3);
  serving.pass(1);
  EXPECT_EQ(viewer.next_cycle(), 3);
  serving.pass(5 * ns_per_s);
  EXPECT_TRUE(viewer.hears_nothing());
}

TEST(HttpViewers, looking_late_does_not_add_up_but_a_second_that_was_missed_is_not_made_up_for) {
  Serving serving;
  Viewer viewer(serving);
  serving.show_cycle(1);
  EXPECT_EQ(viewer.next_cycle(), 1);
  serving.clock.pass(2 * ns_per_s - 1);  // nearly a second late
  serving.show_cycle(2);
  EXPECT_EQ(viewer.next_cycle(), 2);
  serving.show_cycle(3);
  serving.look();
  EXPECT_TRUE(viewer.hears_nothing());
  serving.pass(1);
  EXPECT_EQ(viewer.next_cycle(), 3) << "in step with the first";
  serving.clock.pass(2 * ns_per_s);  // a whole second late
  serving.show_cycle(4);
  EXPECT_EQ(viewer.next_cycle(), 4);
  serving.show_cycle(5);
  serving.pass(ns_per_s - 1);
  EXPECT_TRUE(viewer.hears_nothing());
  serving.pass(1);
  EXPECT_EQ(viewer.next_cycle(), 5);
}

TEST(HttpViewers, each_sees_a_cycle_once_and_who_comes_later_the_same) {
  Serving serving;
  Viewer first(serving);
  serving.show_cycle(7);
  EXPECT_EQ(first.next_cycle(), 7);
  Viewer second(serving);
  serving.pass(ns_per_s);
  EXPECT_EQ(second.next_cycle(), 7);
  EXPECT_TRUE(first.hears_nothing());
  serving.show_cycle(8);
  serving.pass(ns_per_s);
  EXPECT_EQ(first.next_cycle(), 8);
  EXPECT_EQ(second.next_cycle(), 8);
}

TEST(HttpViewers, of_several_spindles_each_sees_its_own) {
  std::vector<SpindleToShow> two;
  for (const char* name : {"left", "right"}) two.push_back(http_serving::spindle(name));
  Serving serving(std::move(two));
  Viewer left(serving, "/api/v1/spindles/left/events"), right(serving, "/api/v1/spindles/right/events");
  serving.show_cycle(3, 1);
  EXPECT_EQ(right.next_cycle(), 3);
  serving.show_cycle(4, 0);
  serving.pass(ns_per_s);
  EXPECT_EQ(left.next_cycle(), 4);
  EXPECT_TRUE(right.hears_nothing());
}

/// Its event is larger than what the system keeps for it.
SpindleToShow with_long_events() {
  SpindleToShow spindle = http_serving::spindle();
  spindle.names.spindle = std::string(200'000, 'x');
  return spindle;
}
constexpr int little_room = 16384;

TEST(HttpViewers, who_takes_an_event_late_gets_the_newest_next_and_has_ten_seconds_each_time) {
  Serving serving(only(with_long_events()));
  Viewer slow(serving, "/api/v1/events", little_room), quick(serving);
  serving.pass(100 * ns_per_s);
  EXPECT_TRUE(serving.counts("viewers", 2)) << "who owes no read has no deadline";
  for (const int cycle : {1, 2, 3}) {
    serving.show_cycle(static_cast<std::uint64_t>(cycle));
    EXPECT_EQ(quick.next_cycle(), cycle);
    serving.pass(ns_per_s);
  }
  serving.pass(7 * ns_per_s - 1);
  EXPECT_EQ(slow.next_cycle(), 1);
  serving.pass(1);
  EXPECT_EQ(slow.next_cycle(), 3);
  serving.show_cycle(4);
  serving.pass(ns_per_s);
  EXPECT_EQ(quick.next_cycle(), 4);
  serving.pass(10 * ns_per_s - 1);
  EXPECT_TRUE(serving.counts("viewers", 2));
  EXPECT_TRUE(serving.has_dropped(0));
  serving.pass(1);
  EXPECT_TRUE(serving.counts("viewers", 1));
  EXPECT_TRUE(serving.has_dropped(1));
}

TEST(HttpViewers, there_are_eight_and_one_that_goes_makes_room) {
  Serving serving;
  std::list<Viewer> viewers;
  for (std::size_t n = 0; n < HttpServer::most_viewers; ++n) viewers.emplace_back(serving);
  EXPECT_EQ(serving.get("/api/v1/events").status, 503);
  EXPECT_EQ(serving.count("viewers"), 8.0);
  viewers.pop_front();
  EXPECT_TRUE(serving.counts("viewers", 7));
  Viewer again(serving);
  EXPECT_EQ(serving.get("/api/v1/events").status, 503);
  EXPECT_TRUE(serving.has_dropped(0));
}

}  // namespace show_http_viewers_test
}  // namespace spindle_twin::firmware
