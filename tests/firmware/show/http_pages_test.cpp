#include <gtest/gtest.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "firmware/show/http_server.hpp"
#include "firmware/show/routes.hpp"
#include "tests/firmware/support/http_serving.hpp"

/// What HttpServer answers by path, of one spindle and of several, and pages that take their time.
namespace spindle_twin::firmware {
namespace show_http_pages_test {

using http_serving::Client;
using http_serving::only;
using http_serving::Reply;
using http_serving::Serving;
using nlohmann::json;

std::vector<SpindleToShow> two() {
  std::vector<SpindleToShow> spindles;
  for (const char* name : {"left", "right"}) spindles.push_back(http_serving::spindle(name));
  return spindles;
}

TEST(HttpPages, the_list_has_each_route_once_and_what_it_says_of_them_stands_in_one_column) {
  Serving one, several(two());
  const auto lines_of = [](const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  };
  const auto expect_list = [&](const auto& listed, const std::string& text) {
    const std::vector<std::string> lines = lines_of(text);
    ASSERT_EQ(lines.size(), 2 + listed.size());
    std::size_t widest = 0;
    for (const Route& route : listed) widest = std::max(widest, std::string(route.path).size());
    for (std::size_t r = 0; r < listed.size(); ++r) {
      const std::string& line = lines[2 + r];
      EXPECT_EQ(line.substr(0, line.find(' ')), listed[r].path);
      EXPECT_EQ(line.find_first_not_of(' ', line.find(' ')), widest + 2) << line;
      EXPECT_EQ(line.substr(widest + 2), listed[r].doc);
    }
  };
  expect_list(routes, one.get("/routes").body);
  expect_list(routes_of_several, several.get("/routes").body);
}

TEST(HttpPages, one_spindle_without_a_name_is_at_its_own_paths_and_no_others) {
  Serving serving;
  serving.show_cycle(5);
  EXPECT_EQ(json::parse(serving.get("/api/v1/state").body)["registers"]["sequence"]["value"], 5);
  for (const Route& route : routes) {
    const std::string path = route.path, doc = route.doc;
    if (doc.starts_with("POST") || path.ends_with("events") || doc.find("history") != std::string::npos) continue;
    EXPECT_EQ(serving.get(path).status, 200) << path;
  }
  EXPECT_EQ(json::parse(serving.get("/api/v1/session").body)["commands"], false);
  EXPECT_EQ(serving.get("/api/v1/scene").body, "{}\n");
  for (const char* path : {"/api/v1/spindles//state", "/api/v1/nothing", "/state", "/api/v2/state"}) {
    EXPECT_EQ(serving.get(path).status, 404) << path;
  }
}

TEST(HttpPages, several_spindles_are_at_their_names_and_so_is_one_that_has_one) {
  for (const bool both : {true, false}) {
    Serving serving(both ? two() : only(http_serving::spindle("left")));
    serving.show_cycle(5, 0);
    if (both) serving.show_cycle(6, 1);
    EXPECT_EQ(json::parse(serving.get("/api/v1/spindles/left/state").body)["registers"]["sequence"]["value"], 5);
    EXPECT_EQ(serving.get("/api/v1/spindles/left/healthz").status, 200);
    EXPECT_EQ(serving.get("/api/v1/spindles/right/scene").status, both ? 200 : 404);
    for (const char* path : {"/api/v1/state", "/api/v1/spindles/left", "/api/v1/spindles/left/nothing"}) {
      EXPECT_EQ(serving.get(path).status, 404) << path;
    }
    const json listed = json::parse(serving.get("/api/v1/spindles").body)["spindles"];
    ASSERT_EQ(listed.size(), both ? 2U : 1U);
    EXPECT_EQ(listed[0]["name"], "left");
    EXPECT_EQ(listed[0]["state"], "running");
    EXPECT_EQ(listed[0]["unit"], 1);
  }
}

TEST(HttpPages, all_are_healthy_only_where_each_is_and_the_first_that_is_not_says_why) {
  Serving serving(two());
  EXPECT_NE(serving.get("/healthz").body.find("left: no prediction"), std::string::npos);
  serving.show_cycle(1, 0);
  const Reply second = serving.get("/healthz");
  EXPECT_EQ(second.status, 503);
  EXPECT_NE(second.body.find("right: no prediction"), std::string::npos);
  serving.show_cycle(1, 1);
  EXPECT_EQ(serving.get("/healthz").status, 200);
  serving.clock.pass(5 * ns_per_s + 1);
  serving.show_cycle(2, 1);
  EXPECT_NE(serving.get("/healthz").body.find("left: the cycle does not run"), std::string::npos);
  EXPECT_EQ(serving.get("/api/v1/spindles/right/healthz").status, 200);
}

TEST(HttpPages, nothing_is_posted_but_where_there_are_commands) {
  Serving serving;
  const auto post = [&](const std::string& path) {
    Client client(serving.server.port());
    client.send("POST " + path + " HTTP/1.1\r\nContent-Length: 0\r\n\r\n");
    return client.read_all().status;
  };
  for (const char* path : {"/", "/routes", "/api/v1/state", "/healthz"}) EXPECT_EQ(post(path), 405) << path;
  EXPECT_EQ(post("/api/v1/command"), 403) << "they are off";
}

/// Pages of a history that are made when it is let go.
struct Gate {
  SpindleToShow spindle() {
    SpindleToShow one = http_serving::spindle();
    one.history = [this](int hours, const std::atomic<bool>& stop) -> Page {
      ++begun;
      while (!open && !stop) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return {200, "text/plain", std::to_string(hours)};
    };
    return one;
  }
  void wait_until_begun(int count) const {
    for (int n = 0; n < 5000 && begun < count; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::atomic<bool> open{false};
  std::atomic<int> begun{0};
};

TEST(HttpPages, a_page_that_takes_its_time_has_a_minute_and_keeps_nobody_waiting_meanwhile) {
  Gate gate;
  Serving serving(only(gate.spindle()));
  Client asks(serving.server.port()), later(serving.server.port());
  asks.ask("/api/v1/history/8");
  serving.look();
  gate.wait_until_begun(1);
  serving.pass(ns_per_s);
  later.ask("/api/v1/history/24");
  serving.look();
  serving.pass(59 * ns_per_s - 1);
  EXPECT_TRUE(asks.hears_nothing());
  serving.pass(1);
  EXPECT_EQ(asks.read_all().status, 503);
  EXPECT_TRUE(later.hears_nothing());
  gate.open = true;
  const Reply made = later.read_all();
  EXPECT_EQ(made.status, 200);
  EXPECT_EQ(made.body, "24") << "and not the page of who has gone";
  EXPECT_TRUE(serving.has_dropped(0)) << "it was answered";
}

TEST(HttpPages, who_breaks_off_has_its_page_not_begun_and_others_get_theirs) {
  Gate gate;
  Serving serving(only(gate.spindle()));
  Client first(serving.server.port()), breaks(serving.server.port()), last(serving.server.port());
  first.ask("/api/v1/history/1");
  serving.look();
  gate.wait_until_begun(1);
  breaks.ask("/api/v1/history/8");
  serving.look();
  last.ask("/api/v1/history/168");
  EXPECT_TRUE(serving.has_clients(3));
  breaks.reset();
  EXPECT_TRUE(serving.has_clients(2));
  gate.open = true;
  EXPECT_EQ(first.read_all().body, "1");
  EXPECT_EQ(last.read_all().body, "168");
  EXPECT_EQ(gate.begun, 2);
}

/// The page under way, which nobody waits for any more, and one of each other connection.
TEST(HttpPages, without_room_for_its_page_a_connection_is_told_so) {
  Gate gate;
  Serving serving(only(gate.spindle()));
  Client breaks(serving.server.port());
  breaks.ask("/api/v1/history/1");
  serving.look();
  gate.wait_until_begun(1);
  breaks.reset();
  EXPECT_TRUE(serving.has_clients(0));
  std::list<Client> asking;
  for (std::size_t n = 1; n < SlowPages::most_at_once; ++n) {
    asking.emplace_back(serving.server.port());
    asking.back().ask("/api/v1/history/8");
    serving.look();
  }
  const Reply refused = serving.get("/api/v1/history/8");
  EXPECT_EQ(refused.status, 503);
  EXPECT_NE(refused.body.find("32 such pages"), std::string::npos) << refused.body;
  gate.open = true;
  for (Client& each : asking) EXPECT_EQ(each.read_all().status, 200);
}

/// Each lane numbers its pages from one on.
TEST(HttpPages, a_command_does_not_wait_for_a_disk_and_gets_its_own_answer) {
  ASSERT_GE(sodium_init(), 0);
  std::array<char, crypto_pwhash_argon2id_STRBYTES> hash{};
  ASSERT_EQ(crypto_pwhash_argon2id_str(hash.data(), "horse", 5, crypto_pwhash_argon2id_OPSLIMIT_MIN,
                                       crypto_pwhash_argon2id_MEMLIMIT_MIN),
            0);
  ShowPlan plan = Serving::plan();
  plan.commands = CommandPlan{"accounts", {{"anna", hash.data()}}, 900.0, 28800.0, false};
  Gate gate;
  Serving serving(only(gate.spindle()), plan);
  Client looks(serving.server.port()), commands(serving.server.port());
  looks.ask("/api/v1/history/8");
  serving.look();
  gate.wait_until_begun(1);
  const std::string body = R"({"user":"anna","password":"horse"})";
  commands.send("POST /api/v1/login HTTP/1.1\r\nX-Spindle-Twin: command\r\nContent-Length: " +
                std::to_string(body.size()) + "\r\n\r\n" + body);
  const Reply in = commands.read_all();
  EXPECT_EQ(in.status, 200);
  EXPECT_NE(in.body.find("\"anna\""), std::string::npos) << in.body;
  EXPECT_TRUE(looks.hears_nothing());
  gate.open = true;
  EXPECT_EQ(looks.read_all().body, "8");
}

}  // namespace show_http_pages_test
}  // namespace spindle_twin::firmware
