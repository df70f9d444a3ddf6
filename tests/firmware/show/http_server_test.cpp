#include "firmware/show/http_server.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/firmware/support/http_serving.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/no_descriptors.hpp"
#include "tests/firmware/support/troubled_poll.hpp"

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
  EXPECT_TRUE(serving.has_clients(1));
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

/// As many connections as there is room for, with those that were there before; what is counted is asked for on them,
/// as each further one would take another's place.
class FullHouse {
 public:
  FullHouse(Serving& serving, std::size_t before) {
    EXPECT_TRUE(serving.has_clients(static_cast<int>(before)));
    for (std::size_t n = before; n < 32; ++n) {
      clients_.push_back(std::make_unique<Client>(serving.server.port()));
      if (n < 20) {
        EXPECT_TRUE(serving.has_clients(static_cast<int>(n + 1)));
      }
    }
  }
  Client& oldest() { return *clients_.front(); }
  /// Whether it comes to that many.
  bool counts(const std::string& connections, const std::string& dropped) {
    for (int n = 0; n < 4; ++n) {
      Client& client = *clients_[clients_.size() - ++asked_];
      client.ask("/metrics");
      const std::string text = client.read_all().body;
      if (text.find("\nspindle_twin_http_connections " + connections + "\n") == std::string::npos) continue;
      return text.find("\nspindle_twin_http_dropped_total " + dropped + "\n") != std::string::npos;
    }
    return false;
  }

 private:
  std::vector<std::unique_ptr<Client>> clients_;
  std::size_t asked_ = 0;
};

TEST(HttpServer, of_32_connections_the_oldest_that_is_no_viewer_makes_room) {
  Serving serving;
  Client viewer(serving.server.port());
  viewer.ask("/api/v1/events");
  EXPECT_NE(viewer.read_until("\r\n\r\n"), "");
  FullHouse house(serving, 1);
  EXPECT_TRUE(house.counts("32", "0"));
  const Client more(serving.server.port());
  EXPECT_TRUE(house.oldest().is_ended());
  EXPECT_TRUE(house.counts("32", "1"));
  EXPECT_TRUE(viewer.hears_nothing());
}

TEST(HttpServer, who_was_answered_makes_room_too_and_is_none_that_was_dropped) {
  Serving serving;
  Client answered(serving.server.port());
  answered.ask("/routes");
  answered.read_all();
  FullHouse house(serving, 1);
  EXPECT_TRUE(house.counts("32", "0"));
  Client more(serving.server.port());
  more.ask("/routes");
  EXPECT_EQ(more.read_all().status, 200);
  EXPECT_TRUE(house.counts("32", "0"));
  EXPECT_TRUE(house.oldest().hears_nothing());
}

constexpr std::size_t longest_request = 8192, longest_body = 2048;

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
  for (const std::size_t bytes : {std::size_t{4096}, std::size_t{4097}, longest_request}) {
    ASSERT_EQ(head_of(bytes).size(), bytes);
    Client fits(serving.server.port());
    fits.send(head_of(bytes));
    EXPECT_EQ(fits.read_all().status, 200) << bytes;
  }
  Client more(serving.server.port());
  more.send(head_of(longest_request + 1));
  EXPECT_EQ(more.read_all().status, 431);
  Client endless(serving.server.port());
  endless.send(std::string(longest_request, 'x'));
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
  fits.send(post(longest_body) + std::string(longest_body - 1, 'x'));
  serving.look();
  EXPECT_TRUE(fits.hears_nothing());
  fits.send("x");
  EXPECT_EQ(fits.read_all().status, 403) << "commands are off";
  Client more(serving.server.port());
  more.send(post(longest_body + 1));
  EXPECT_EQ(more.read_all().status, 413);
  Client both(serving.server.port());
  both.send(head_of(longest_request + 1, "POST /api/v1/login HTTP/1.1\r\nContent-Length: 2048\r\n"));
  EXPECT_EQ(both.read_all().status, 431) << "it is the head that has no room";
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

/// Who has connected before can ask; who connects now waits in the backlog. Nobody closes anything meanwhile, which
/// would leave a descriptor.
TEST(HttpServer, without_a_descriptor_nobody_is_accepted_for_a_second_and_then_who_has_waited) {
  Serving serving;
  Client waits(0);  // has its descriptor, and no connection yet
  FullHouse house(serving, 0);
  ASSERT_TRUE(house.counts("32", "0"));
  // An answer shows that the server has looked; what it accepts then, it accepts behind that: so two of them.
  const auto looks = [&] { return house.counts("32", "0") && house.counts("32", "0"); };
  {
    const NoDescriptors none;
    waits.connect(serving.server.port());
    waits.ask("/routes");
    EXPECT_TRUE(looks());
  }
  serving.clock.pass(ns_per_s - 1);
  EXPECT_TRUE(looks());
  EXPECT_TRUE(waits.hears_nothing());
  serving.clock.pass(1);
  house.counts("32", "0");
  EXPECT_EQ(waits.read_all().status, 200);
}

/// poll() refuses more descriptors than a process may have.
TEST(HttpServer, behind_a_poll_that_failed_it_rests_a_tenth_of_a_second_says_so_and_goes_on) {
  const Logged log;
  {
    Serving serving;
    Client asks(serving.server.port());
    EXPECT_TRUE(serving.has_clients(1));
    const std::int64_t began_ns = serving.clock.now_ns();
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    const rlimit none{2, before.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
    asks.send("GET /rou");  // the next poll fails
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (serving.clock.now_ns() == began_ns && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    ::setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(serving.get("/routes").status, 200);
    EXPECT_GT(serving.clock.now_ns(), began_ns);
    EXPECT_EQ((serving.clock.now_ns() - began_ns) % (ns_per_s / 10), 0);
  }
  EXPECT_NE(log.text().find("error http: poll: Invalid argument"), std::string::npos) << log.text();
}

TEST(HttpServer, its_rest_behind_a_poll_that_failed_is_a_tenth_of_a_second_from_when_it_failed) {
  RestingClock clock;
  HttpServer server(Serving::plan(), only(http_serving::spindle()), clock);
  std::thread thread([&] { server.run(); });
  Client asks(server.port());
  asks.ask("/routes");
  EXPECT_EQ(asks.read_all().status, 200);
  Client wakes(0);
  {
    const NoPoll none;
    wakes.connect(server.port());  // the next poll fails, or the one behind it
    clock.wait_until_it_rests();
  }
  clock.wake();
  EXPECT_EQ(clock.rest_ns, ns_per_s / 10);
  server.stop();
  thread.join();
}

TEST(HttpServer, a_signal_ends_nothing_and_is_no_error) {
  const Interruption quiet;
  const Logged log;
  {
    Serving serving;
    for (int n = 0; n < 20; ++n) {
      Interruption::of(serving.thread);
      ASSERT_EQ(serving.get("/routes").status, 200);
    }
  }
  EXPECT_EQ(log.text(), "");
}

TEST(HttpServer, a_deadline_is_kept_though_nothing_else_happens) {
  Serving serving;
  Client first(serving.server.port());
  EXPECT_TRUE(serving.has_clients(1));
  serving.clock.pass(ns_per_s);
  Client later(serving.server.port());
  EXPECT_TRUE(serving.has_clients(2));
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

bool sleeps(const Serving& serving) {
  long asked = -1;
  for (int n = 0; n < 20 && asked != serving.clock.asked; ++n) {
    asked = serving.clock.asked;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return asked == serving.clock.asked;
}

TEST(HttpServer, it_sleeps_beside_who_says_nothing_and_who_says_more_than_it_reads) {
  Serving serving(only(with_much_to_read()));
  const Client silent(serving.server.port());
  EXPECT_TRUE(serving.has_clients(1));
  EXPECT_TRUE(sleeps(serving));
  Client stuck(serving.server.port(), INADDR_LOOPBACK, little_room);
  stuck.ask("/api/v1/scene");
  serving.look();
  stuck.send("more");
  EXPECT_TRUE(sleeps(serving));
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
