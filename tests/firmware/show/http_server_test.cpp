#include "firmware/show/http_server.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/firmware/support/http_serving.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/no_descriptors.hpp"

/// Who asks slowly, reads nothing, breaks off, or is one too many. No viewers and no slow pages.
namespace spindle_twin::firmware {
namespace show_http_server_test {

using http_serving::Client;
using http_serving::only;
using http_serving::Reply;
using http_serving::Serving;

/// More than the system keeps for who does not read.
constexpr std::size_t much = 200'000;
constexpr int little_room = 16384;
SpindleToShow with_much_to_read() {
  SpindleToShow spindle = http_serving::spindle();
  spindle.scene = std::string(much, 'x');
  return spindle;
}
TEST(HttpServer, a_request_has_two_seconds_from_its_connection_to_its_last_byte) {
  Serving serving;
  Client slow(serving.server.port());
  serving.look();
  serving.pass(2 * ns_per_s - 1);
  slow.send("GET /routes HTTP");  // does not begin them anew
  EXPECT_TRUE(serving.has_clients(1));
  EXPECT_TRUE(serving.has_dropped(0));
  serving.pass(1);
  EXPECT_TRUE(slow.is_ended());
  EXPECT_TRUE(serving.has_clients(0));
  EXPECT_TRUE(serving.has_dropped(1));
}

TEST(HttpServer, an_answer_has_five_seconds_to_be_taken) {
  Serving serving(only(with_much_to_read()));
  Client stuck(serving.server.port(), INADDR_LOOPBACK, little_room), reads(serving.server.port());
  stuck.ask("/api/v1/scene");
  serving.look();
  serving.pass(ns_per_s);
  reads.ask("/api/v1/scene");
  EXPECT_GT(reads.read_all().body.size(), much);
  reads.close();
  serving.pass(4 * ns_per_s - 1);
  EXPECT_TRUE(serving.has_clients(1));
  EXPECT_TRUE(serving.has_dropped(0));
  serving.pass(1);
  EXPECT_TRUE(serving.has_clients(0));
  EXPECT_TRUE(serving.has_dropped(1));
}

/// What it says meanwhile is read and forgotten: unread, it would turn the end into a reset.
TEST(HttpServer, who_was_answered_has_a_second_to_go_and_is_none_that_was_dropped) {
  Serving serving;
  Client stays(serving.server.port());
  stays.ask("/routes");
  EXPECT_EQ(stays.read_all().status, 200);
  stays.send(std::string(100'000, 'x') + "\r\n\r\nGET /routes HTTP/1.1\r\n\r\n");
  serving.look();
  serving.pass(ns_per_s - 1);
  EXPECT_TRUE(serving.has_clients(1));
  serving.pass(1);
  EXPECT_TRUE(serving.has_clients(0));
  EXPECT_TRUE(serving.has_dropped(0));
}

TEST(HttpServer, who_goes_or_breaks_off_is_gone_at_once_whatever_it_had_asked) {
  Serving serving(only(with_much_to_read()));
  for (const char* request : {"", "GET /rou", "GET /routes HTTP/1.1\r\n\r\n", "GET /api/v1/scene HTTP/1.1\r\n\r\n",
                              "GET /api/v1/events HTTP/1.1\r\n\r\n"}) {
    Client breaks(serving.server.port(), INADDR_LOOPBACK, little_room);
    breaks.send(request);
    EXPECT_TRUE(serving.has_clients(1)) << request;
    breaks.reset();
    EXPECT_TRUE(serving.has_clients(0)) << request;
  }
  Client goes(serving.server.port());
  EXPECT_TRUE(serving.has_clients(1));
  goes.close();
  EXPECT_TRUE(serving.has_clients(0));
  EXPECT_TRUE(serving.has_dropped(0));
}

TEST(HttpServer, of_32_connections_the_oldest_that_is_no_viewer_makes_room) {
  Serving serving;
  Client viewer(serving.server.port());
  viewer.ask("/api/v1/events");
  EXPECT_NE(viewer.read_until("\r\n\r\n"), "");
  std::list<Client> idle;
  for (int n = 0; n < 30; ++n) {
    idle.emplace_back(serving.server.port());
    serving.look();
  }
  EXPECT_TRUE(serving.has_clients(31)) << "and the one that asks";
  EXPECT_TRUE(serving.has_dropped(0));
  idle.emplace_back(serving.server.port());
  EXPECT_TRUE(serving.has_clients(31));
  EXPECT_TRUE(serving.has_dropped(1));
  EXPECT_TRUE(idle.front().is_ended());
  idle.pop_front();
  for (Client& each : idle) {
    EXPECT_TRUE(each.hears_nothing());
  }
  EXPECT_TRUE(viewer.hears_nothing());
}

TEST(HttpServer, who_was_answered_makes_room_first_come_and_is_none_that_was_dropped) {
  Serving serving;
  Client answered(serving.server.port());
  answered.ask("/routes");
  answered.read_all();
  std::list<Client> idle;
  for (int n = 0; n < 31; ++n) idle.emplace_back(serving.server.port());
  serving.look();
  EXPECT_TRUE(serving.has_clients(31));
  EXPECT_TRUE(serving.has_dropped(0));
}

std::string head_of(std::size_t bytes, const std::string& first = "GET /routes HTTP/1.1\r\n") {
  std::string head = first;
  while (head.size() + 2 < bytes) {
    const std::size_t room = bytes - head.size() - 2;
    const std::size_t line = room < 2000 ? room : 1000;
    head += "X: " + std::string(line - 5, 'x') + "\r\n";
  }
  return head + "\r\n";
}

TEST(HttpServer, a_head_may_have_8_KiB_and_not_a_byte_more) {
  Serving serving;
  for (const std::size_t bytes : {std::size_t{4096}, std::size_t{4097}, HttpServer::longest_request}) {
    ASSERT_EQ(head_of(bytes).size(), bytes);
    Client fits(serving.server.port());
    fits.send(head_of(bytes));
    EXPECT_EQ(fits.read_all().status, 200) << bytes;
  }
  Client more(serving.server.port());
  more.send(head_of(HttpServer::longest_request + 1));
  EXPECT_EQ(more.read_all().status, 431);
  Client endless(serving.server.port());
  endless.send(std::string(HttpServer::longest_request, 'x'));
  serving.look();
  EXPECT_TRUE(endless.hears_nothing()) << "its end may come yet";
  endless.send("x");
  EXPECT_EQ(endless.read_all().status, 431);
}

TEST(HttpServer, a_body_may_have_2_KiB_and_is_waited_for) {
  Serving serving;
  const auto post = [](std::size_t bytes) {
    return "POST /api/v1/login HTTP/1.1\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n";
  };
  Client fits(serving.server.port());
  fits.send(post(HttpServer::longest_body) + std::string(HttpServer::longest_body - 1, 'x'));
  serving.look();
  EXPECT_TRUE(fits.hears_nothing());
  fits.send("x");
  EXPECT_EQ(fits.read_all().status, 403) << "commands are off";
  Client more(serving.server.port());
  more.send(post(HttpServer::longest_body + 1));
  EXPECT_EQ(more.read_all().status, 413);
  Client none(serving.server.port());
  none.send(post(0));
  EXPECT_EQ(none.read_all().status, 403);
}

TEST(HttpServer, answers_are_counted_by_their_status) {
  Serving serving;
  const double before = serving.count("requests_total{code=\"200\"}");
  for (int n = 0; n < 3; ++n) EXPECT_EQ(serving.get("/nothing").status, 404);
  EXPECT_EQ(serving.get("/routes").status, 200);
  EXPECT_EQ(serving.count("requests_total{code=\"404\"}"), 3.0);
  EXPECT_EQ(serving.count("requests_total{code=\"200\"}"), std::max(before, 0.0) + 3.0) << "the list and two counts";
}

TEST(HttpServer, who_is_not_allowed_gets_no_answer_and_a_line_in_the_log) {
  constexpr std::uint32_t other = INADDR_LOOPBACK + 1;
  const Logged log;
  ShowPlan plan = Serving::plan();
  plan.allow = {*parse_address_range("127.0.0.2")};
  Serving serving(only(http_serving::spindle()), plan);
  Client stranger(serving.server.port()), guest(serving.server.port(), other);
  stranger.ask("/routes");
  guest.ask("/routes");
  EXPECT_EQ(stranger.read_all().status, 0);
  EXPECT_EQ(guest.read_all().status, 200);
  EXPECT_NE(log.text().find("warning client 127.0.0.1 is not in http.allow\n"), std::string::npos) << log.text();
}

/// Who has connected before can ask; who connects now waits in the backlog.
TEST(HttpServer, without_a_descriptor_nobody_is_accepted_for_a_second_and_then_who_has_waited) {
  Serving serving;
  std::vector<std::unique_ptr<Client>> before;
  for (int n = 0; n < 6; ++n) before.push_back(std::make_unique<Client>(serving.server.port()));
  serving.look();
  // An answer shows that the server has looked; what it accepts then, it accepts behind that: so two of them. Nobody
  // closes anything, which would leave a descriptor.
  std::size_t asked = 0;
  const auto look = [&] {
    for (int n = 0; n < 2; ++n, ++asked) {
      before[asked]->ask("/routes");
      EXPECT_EQ(before[asked]->read_all().status, 200);
    }
  };
  Client waits(0);  // has its descriptor, and no connection yet
  {
    const NoDescriptors none;
    waits.connect(serving.server.port());
    waits.ask("/routes");
    look();
  }
  serving.clock.pass(ns_per_s - 1);
  look();
  EXPECT_TRUE(waits.hears_nothing());
  serving.clock.pass(1);
  look();
  EXPECT_EQ(waits.read_all().status, 200);
}

TEST(HttpServer, a_deadline_is_kept_though_nothing_else_happens) {
  Serving serving;
  Client first(serving.server.port());
  serving.look();
  serving.clock.pass(ns_per_s);
  Client later(serving.server.port());
  serving.look();
  serving.pass(ns_per_s - 1);
  EXPECT_TRUE(first.hears_nothing());
  serving.clock.pass(1);
  EXPECT_TRUE(first.is_ended());
  EXPECT_TRUE(later.hears_nothing());
  serving.pass(ns_per_s - 1);
  EXPECT_TRUE(later.hears_nothing());
  serving.clock.pass(1);
  EXPECT_TRUE(later.is_ended());
}

/// Some time after the last client has gone, that is.
TEST(HttpServer, with_nobody_there_it_sleeps) {
  Serving serving;
  serving.look();
  long asked = -1;
  for (int n = 0; n < 20 && asked != serving.clock.asked; ++n) {
    asked = serving.clock.asked;
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
  }
  EXPECT_EQ(serving.clock.asked, asked) << "not one look at the clock";
}

}  // namespace show_http_server_test
}  // namespace spindle_twin::firmware
