#include "firmware/show/http_answer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>

#include "firmware/show/json_text.hpp"
#include "firmware/show/routes.hpp"

namespace spindle_twin::firmware {
namespace show_http_answer_test {

class Answers : public ::testing::Test {
 protected:
  HttpAnswer answer(const std::string& request) { return answerer_.answer(request); }

  HttpAnswerer answerer_{[this](const HttpRequest& request) -> Page {
    const std::string& path = request.path;
    asked_ = request;
    if (path == "/command") return request.is_post ? Page{202, "application/json", "{}"} : Page{405};
    if (request.is_post) return {405};
    if (path == "/events") return {200, "text/event-stream", "", true};
    if (path == "/sick") return {503, "application/json", "{\"error\":\"own words\"}"};
    if (path == "/slow") {
      Page page;
      page.work = [](const std::atomic<bool>&) { return Page{200, "text/plain", "at last"}; };
      return page;
    }
    if (path == "/none") return {404, "application/json", "{\"error\":\"there is none\"}"};
    if (path == "/throws") throw std::runtime_error("a page went wrong");
    return path == "/" ? Page{200, "text/plain", "hello"} : Page{404};
  }};
  HttpRequest asked_;  ///< last
};

TEST_F(Answers, every_answer_ends_its_connection_and_is_not_to_be_stored) {
  const HttpAnswer good = answer("GET / HTTP/1.1\r\nConnection: keep-alive\r\n\r\n");
  EXPECT_EQ(good.status, 200);
  EXPECT_FALSE(good.is_stream);
  EXPECT_TRUE(good.bytes.starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_TRUE(good.bytes.ends_with("\r\n\r\nhello"));
  for (const char* line :
       {"\r\nConnection: close\r\n", "\r\nCache-Control: no-store\r\n", "\r\nContent-Length: 5\r\n"}) {
    EXPECT_NE(good.bytes.find(line), std::string::npos) << good.bytes;
  }
}

TEST_F(Answers, a_page_may_say_itself_what_is_wrong) {
  const HttpAnswer sick = answer("GET /sick HTTP/1.1\r\n\r\n");
  EXPECT_EQ(sick.status, 503);
  EXPECT_TRUE(sick.bytes.ends_with("{\"error\":\"own words\"}"));
}

TEST_F(Answers, of_what_is_not_there_a_page_may_say_why) {
  EXPECT_TRUE(answer("GET /none HTTP/1.1\r\n\r\n").bytes.ends_with("{\"error\":\"there is none\"}"));
  EXPECT_NE(answer("GET /nothing HTTP/1.1\r\n\r\n").bytes.find("see /routes"), std::string::npos);
}

TEST_F(Answers, a_page_that_takes_its_time_is_answered_when_it_is_made) {
  for (const std::string method : {"GET", "HEAD"}) {
    const std::string request = method + " /slow HTTP/1.1\r\n\r\n";
    const HttpAnswer asked = answer(request);
    ASSERT_TRUE(asked.work);
    EXPECT_TRUE(asked.bytes.empty());
    const HttpAnswer made = answerer_.answer(request, asked.work(std::atomic<bool>{false}));
    EXPECT_FALSE(made.work);
    EXPECT_TRUE(made.bytes.starts_with("HTTP/1.1 200 OK\r\n"));
    EXPECT_NE(made.bytes.find("\r\nContent-Length: 7\r\n"), std::string::npos);
    EXPECT_EQ(made.bytes.ends_with("\r\n\r\nat last"), method == "GET") << made.bytes;
  }
  EXPECT_FALSE(answer("POST /slow HTTP/1.1\r\n\r\n").work);
  EXPECT_FALSE(answer("GET /slow HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n").work);
}

TEST_F(Answers, a_page_that_throws_is_500_and_the_next_one_is_answered) {
  EXPECT_EQ(answer("GET /throws HTTP/1.1\r\n\r\n").status, 500);
  EXPECT_EQ(answer("GET / HTTP/1.1\r\n\r\n").status, 200);
}

TEST_F(Answers, a_stream_is_a_head_without_length_and_of_head_it_is_none) {
  const HttpAnswer stream = answer("GET /events HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(stream.is_stream);
  EXPECT_TRUE(stream.bytes.ends_with("\r\n\r\n"));
  EXPECT_EQ(stream.bytes.find("Content-Length"), std::string::npos);
  EXPECT_EQ(stream.bytes.find("Transfer-Encoding"), std::string::npos);
  EXPECT_FALSE(answer("HEAD /events HTTP/1.1\r\n\r\n").is_stream);
}

TEST_F(Answers, only_who_asks_for_this_host_is_answered) {
  HttpAnswerer named([](const HttpRequest&) { return Page{200, "text/plain", "hello"}; }, {"twin.example", "CNC-Twin"});
  const auto status_for = [&](const std::string& host) {
    return named.answer("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n").status;
  };
  for (const char* host : {"127.0.0.1", "127.0.0.1:9502", "192.168.7.3:80", "[::1]:9502", "localhost", "LocalHost:1",
                           "cnc-twin:9502", "CNC-TWIN", "twin.example", "Twin.Example:9502"}) {
    EXPECT_EQ(status_for(host), 200) << host;
  }
  for (const char* host : {"elsewhere.example", "127.0.0.1.elsewhere.example", "localhost.example:9502", "a b"}) {
    EXPECT_EQ(status_for(host), 421) << host;
  }
  const HttpAnswer refused = named.answer("GET / HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n");
  EXPECT_NE(refused.bytes.find("http.names"), std::string::npos) << refused.bytes;
  EXPECT_EQ(refused.bytes.find("hello"), std::string::npos);
}

TEST_F(Answers, a_page_hears_who_posts_what_and_whether_one_of_ours_does) {
  const std::string head = "POST /command HTTP/1.1\r\nHost: 127.0.0.1:9502\r\nCookie: a=b; c=d\r\n";
  EXPECT_EQ(answerer_.answer(head + "\r\n{\"x\":\r\n\r\n1}", std::nullopt, 7).status, 202);
  EXPECT_EQ(asked_.body, "{\"x\":\r\n\r\n1}");
  EXPECT_EQ(asked_.cookie, "a=b; c=d");
  EXPECT_EQ(asked_.peer, 7U);
  EXPECT_FALSE(asked_.is_from_a_page);
  const auto is_ours = [&](const std::string& lines) {
    answer(head + lines + "\r\n");
    return asked_.is_from_a_page;
  };
  const std::string own = "X-Spindle-Twin: command\r\n";
  EXPECT_TRUE(is_ours(own));
  EXPECT_TRUE(is_ours(own + "Origin: http://127.0.0.1:9502\r\n"));
  EXPECT_TRUE(is_ours(own + "Origin: https://127.0.0.1:9502\r\n"));
  EXPECT_FALSE(is_ours(own + "Origin: http://elsewhere.example\r\n"));
  EXPECT_FALSE(is_ours(own + "Origin: null\r\n"));
  EXPECT_FALSE(is_ours("X-Spindle-Twin: 1\r\n"));
  EXPECT_NE(answer("GET /command HTTP/1.1\r\n\r\n").bytes.find("\r\nAllow: POST\r\n"), std::string::npos);
  EXPECT_NE(answer("POST / HTTP/1.1\r\n\r\n").bytes.find("\r\nAllow: GET, HEAD\r\n"), std::string::npos);
}

TEST_F(Answers, what_is_not_allowed_is_said_in_words_that_fit_the_path) {
  const auto says = [&](const std::string& method, const std::string& path) {
    const HttpAnswer got = answer(method + " " + path + " HTTP/1.1\r\n\r\n");
    EXPECT_EQ(got.status, 405) << method << " " << path;
    return got.bytes;
  };
  EXPECT_TRUE(says("GET", "/command").ends_with("{\"error\":\"only POST is allowed here\"}\n"));
  EXPECT_NE(says("HEAD", "/command").find("\r\nAllow: POST\r\n"), std::string::npos);
  for (const char* method : {"POST", "PUT", "DELETE"}) {
    const std::string bytes = says(method, "/");
    EXPECT_TRUE(bytes.ends_with("{\"error\":\"only GET and HEAD are allowed: nothing can be changed here\"}\n"))
        << bytes;
    EXPECT_NE(bytes.find("\r\nAllow: GET, HEAD\r\n"), std::string::npos) << bytes;
  }
  const HttpAnswer garbage = answer("nonsense\r\n\r\n");
  EXPECT_EQ(garbage.status, 400);
  EXPECT_TRUE(garbage.bytes.ends_with("{\"error\":\"this request is not understood\"}\n")) << garbage.bytes;
  EXPECT_EQ(answer("HEAD / HTTP/1.1\r\n\r\n").status, 200);
}

TEST_F(Answers, this_computer_is_known_by_its_own_name_and_by_none) {
  std::array<char, 300> name{};
  ASSERT_EQ(gethostname(name.data(), name.size() - 1), 0);
  const std::string own = name.data();
  if (own.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") == std::string::npos) {
    EXPECT_EQ(answer("GET / HTTP/1.1\r\nHost: " + own + ":9502\r\n\r\n").status, 200) << own;
  }
  EXPECT_EQ(answer("GET / HTTP/1.0\r\n\r\n").status, 200) << "HTTP/1.0 says none";
}

TEST(HttpAnswerer, what_is_too_long_is_told_apart_and_its_answer_is_whole) {
  for (const bool body : {false, true}) {
    const HttpAnswer answer = HttpAnswerer::too_long(body);
    EXPECT_EQ(answer.status, body ? 413 : 431);
    EXPECT_TRUE(answer.bytes.starts_with(body ? "HTTP/1.1 413 Payload Too Large\r\n"
                                              : "HTTP/1.1 431 Request Header Fields Too Large\r\n"));
    const std::size_t end = answer.bytes.find("\r\n\r\n");
    const std::string length = std::to_string(answer.bytes.size() - end - 4);
    EXPECT_NE(answer.bytes.find("\r\nContent-Length: " + length + "\r\n"), std::string::npos);
  }
}

TEST(HttpAnswerer, a_body_is_as_long_as_the_head_of_a_post_says) {
  const auto bytes = [](const std::string& first, const std::string& line) {
    return HttpAnswerer::body_bytes(first + " /api/v1/command HTTP/1.1\r\n" + line + "\r\n\r\n");
  };
  EXPECT_EQ(bytes("POST", "Content-Length: 17"), 17U);
  EXPECT_EQ(bytes("POST", "content-LENGTH:17"), 17U);
  EXPECT_GT(bytes("POST", "Content-Length: 99999999999999999999999"), 1U << 30U);
  EXPECT_EQ(bytes("POST", "Content-Length: -1"), 0U);
  EXPECT_EQ(bytes("POST", "Content-Length:"), 0U);
  EXPECT_EQ(bytes("POST", "X-Content-Length: 5"), 0U);
  EXPECT_EQ(bytes("GET", "Content-Length: 17"), 0U);
  EXPECT_EQ(HttpAnswerer::body_bytes("POST / HTTP/1.1\r\nContent-Length: 17\r\n\r\n"), 0U);
}

TEST_F(Answers, a_body_is_not_waited_for) {
  EXPECT_EQ(answer("POST / HTTP/1.1\r\nContent-Length: 1000000000\r\n\r\n").status, 405);
  EXPECT_EQ(answer("GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nExpect: 100-continue\r\n\r\n").status, 200);
}

TEST_F(Answers, of_broken_requests_none_is_answered_by_more_than_an_error_or_the_page) {
  const std::string whole = "GET / HTTP/1.1\r\nHost: ::1\r\nRange: bytes=0-1\r\nAccept: */*\r\n\r\n";
  std::mt19937 random(1);
  for (int n = 0; n < 20000; ++n) {
    std::string broken = whole;
    for (unsigned change = 0; change <= random() % 6; ++change) {
      const std::size_t at = random() % broken.size();
      broken[at] = static_cast<char>(random());
      if (random() % 5 == 0) broken.resize(at + 1);
    }
    const HttpAnswer got = answer(broken + "\r\n\r\n");
    EXPECT_TRUE(got.bytes.empty() || got.bytes.starts_with("HTTP/1.")) << broken;
    EXPECT_LT(got.bytes.size(), 10000U) << broken;
  }
}

TEST(Routes, the_readme_names_each_one_in_its_own_words) {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/firmware/README.md");
  const std::string readme{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto stands = [&](const Route& route) {
    return readme.find("| `" + std::string(route.path) + "` | " + route.doc + " |") != std::string::npos;
  };
  for (const Route& route : routes) EXPECT_TRUE(stands(route)) << route.path;
  for (const Route& route : routes_of_several) EXPECT_TRUE(stands(route)) << route.path;
}

TEST(JsonText, quotes_backslashes_and_control_characters_are_escaped) {
  EXPECT_EQ(json_text("a\"b\\c\n\x01 \xC2\xB5m"), "\"a\\\"b\\\\c\\u000a\\u0001 \xC2\xB5m\"");
}

}  // namespace show_http_answer_test
}  // namespace spindle_twin::firmware
