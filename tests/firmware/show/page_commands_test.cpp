#include "firmware/show/page_commands.hpp"

#include <gtest/gtest.h>
#include <sodium.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tests/firmware/support/logged.hpp"

namespace spindle_twin::firmware {
namespace show_page_commands_test {

class SetClock final : public Clock {
 public:
  std::int64_t now_ns() const override { return now; }
  void sleep_until_ns(std::int64_t time_ns) override { now = time_ns; }
  std::int64_t now = ns_per_s;
};

/// Quick to try, as many are.
std::string quick_hash(const std::string& password) {
  std::array<char, crypto_pwhash_argon2id_STRBYTES> hash{};
  EXPECT_GE(sodium_init(), 0);
  EXPECT_EQ(crypto_pwhash_argon2id_str(hash.data(), password.data(), password.size(),
                                       crypto_pwhash_argon2id_OPSLIMIT_MIN, crypto_pwhash_argon2id_MEMLIMIT_MIN),
            0);
  return hash.data();
}

class PageOrders : public ::testing::Test {
 protected:
  static CommandPlan plan() { return {"accounts", {{"anna", quick_hash("correct horse")}}, 900.0, 28800.0, false}; }
  static HttpRequest post(const std::string& body, const std::string& cookie = "") {
    return {true, "", body, cookie, true, 0x7F000001U};
  }
  /// What comes in the end, work included.
  static Page made(Page page) { return page.work ? page.work(std::atomic<bool>{false}) : page; }
  Page log_in(const std::string& password, const std::string& user = "anna") {
    return made(commands_->log_in(post(R"({"user":")" + user + R"(","password":")" + password + "\"}")));
  }
  Page order(const std::string& body, const std::string& cookie) {
    return made(commands_->command(post(body, cookie), {"", outputs_, give_}));
  }
  /// The part of Set-Cookie that comes back.
  static std::string cookie_of(const Page& page) { return page.cookie.substr(0, page.cookie.find(';')); }

  SetClock clock_;
  std::optional<PageCommands> commands_{std::in_place, plan(), clock_};
  std::vector<std::string> outputs_{"nose"};
  std::vector<Order> given_;
  bool has_room_ = true;
  GiveOrder give_ = [this](const Order& order) {
    if (has_room_) given_.push_back(order);
    return has_room_;
  };
  const std::string tare_ = R"({"command":"tare","value":"take"})";
};

TEST_F(PageOrders, an_order_is_refused_before_login_and_given_after) {
  EXPECT_EQ(order(tare_, "").status, 401);
  EXPECT_EQ(order(tare_, "spindle_twin_session=" + std::string(64, 'a')).status, 401);
  EXPECT_TRUE(given_.empty());
  const Page in = log_in("correct horse");
  EXPECT_EQ(in.status, 200);
  const Page taken = order(tare_, "theme=dark; " + cookie_of(in));
  EXPECT_EQ(taken.status, 202);
  EXPECT_EQ(taken.body, "{\"order_id\":60001}\n");
  ASSERT_EQ(given_.size(), 1U);
  EXPECT_EQ(given_[0].kind, OrderKind::tare);
  EXPECT_EQ(given_[0].id, 60001);
  EXPECT_EQ(order(tare_, cookie_of(in)).body, "{\"order_id\":60002}\n");
}

TEST_F(PageOrders, a_wrong_password_and_an_unknown_name_are_told_alike) {
  const Page wrong = log_in("correct mule"), unknown = log_in("correct horse", "bert");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(unknown.status, 401);
  EXPECT_EQ(wrong.body, unknown.body);
  EXPECT_TRUE(wrong.cookie.empty());
  EXPECT_EQ(log_in("nobody has this password", "bert").status, 401);
}

TEST_F(PageOrders, the_cookie_is_for_no_script_no_other_site_and_behind_tls_for_no_other_way) {
  EXPECT_TRUE(log_in("correct horse").cookie.ends_with("; Path=/; HttpOnly; SameSite=Strict"));
  CommandPlan behind = plan();
  behind.behind_tls = true;
  commands_.emplace(behind, clock_);
  EXPECT_TRUE(log_in("correct horse").cookie.ends_with("; HttpOnly; SameSite=Strict; Secure"));
}

TEST_F(PageOrders, tries_are_limited_whether_right_or_wrong) {
  for (int n = 0; n < 5; ++n) EXPECT_EQ(log_in("guess").status, 401);
  const Page late = log_in("correct horse");
  EXPECT_EQ(late.status, 429);
  EXPECT_EQ(late.body, "{\"error\":\"too many logins: try again in 12 s\"}\n");
  clock_.now += 12 * ns_per_s - 1;
  EXPECT_EQ(log_in("correct horse").body, "{\"error\":\"too many logins: try again in 1 s\"}\n");
  clock_.now += 1;
  EXPECT_EQ(log_in("correct horse").status, 200);
}

TEST_F(PageOrders, each_order_keeps_the_session_for_another_quarter_of_an_hour) {
  const std::string cookie = cookie_of(log_in("correct horse"));
  for (int n = 0; n < 5; ++n) {
    clock_.now += 14 * 60 * ns_per_s;
    EXPECT_EQ(order(tare_, cookie).status, 202) << n;
  }
  clock_.now += 15 * 60 * ns_per_s;
  EXPECT_EQ(order(tare_, cookie).status, 401);
}

TEST_F(PageOrders, a_session_ends_by_logout_and_by_idleness_while_looking_on_does_not_keep_it) {
  const std::string first = cookie_of(log_in("correct horse"));
  EXPECT_EQ(commands_->session({false, "", "", first}).body, "{\"commands\":true,\"user\":\"anna\"}\n");
  const Page out = commands_->log_out(post("", first));
  EXPECT_EQ(out.status, 200);
  EXPECT_NE(out.cookie.find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(order(tare_, first).status, 401);
  const std::string second = cookie_of(log_in("correct horse"));
  for (int minute = 0; minute < 15; ++minute) {
    commands_->session({false, "", "", second});
    clock_.now += 60 * ns_per_s;
  }
  EXPECT_EQ(order(tare_, second).status, 401);
  EXPECT_EQ(commands_->session({false, "", "", second}).body, "{\"commands\":true,\"user\":null}\n");
}

TEST_F(PageOrders, another_pages_request_is_refused_although_the_cookie_came_with_it) {
  HttpRequest forged = post(tare_, cookie_of(log_in("correct horse")));
  forged.is_from_a_page = false;
  EXPECT_EQ(commands_->command(forged, {"", outputs_, give_}).status, 403);
  EXPECT_EQ(commands_->log_in(forged).status, 403);
  EXPECT_EQ(commands_->log_out(forged).status, 403);
  EXPECT_TRUE(given_.empty());
}

TEST_F(PageOrders, without_a_plan_all_is_refused_with_the_key_that_is_missing) {
  commands_.emplace(std::nullopt, clock_);
  EXPECT_FALSE(commands_->enabled());
  for (const Page& page : {log_in("correct horse"), order(tare_, ""), commands_->log_out(post(""))}) {
    EXPECT_EQ(page.status, 403);
    EXPECT_EQ(page.body, "{\"error\":\"commands are off: the configuration has no [http.commands]\"}\n");
  }
  EXPECT_EQ(commands_->session({}).body, "{\"commands\":false,\"user\":null}\n");
}

TEST_F(PageOrders, a_full_queue_and_a_bad_body_are_said_and_nothing_is_given) {
  const std::string cookie = cookie_of(log_in("correct horse"));
  has_room_ = false;
  EXPECT_EQ(order(tare_, cookie).status, 503);
  EXPECT_EQ(order("{}", cookie).status, 400);
  EXPECT_EQ(made(commands_->log_in(post("{\"user\":\"anna\"}"))).body, "{\"error\":\"password: must be a text\"}\n");
  EXPECT_EQ(made(commands_->log_in(post("anna"))).status, 400);
  EXPECT_EQ(commands_->command({}, {"", outputs_, give_}).status, 405);
}

TEST_F(PageOrders, a_trial_goes_on_only_by_the_session_that_began_it_and_looking_on_keeps_no_session) {
  const std::string go_on = R"({"command":"trial","value":"go_on"})";
  const std::string first = cookie_of(log_in("correct horse")), second = cookie_of(log_in("correct horse"));
  EXPECT_EQ(order(go_on, first).status, 409);
  EXPECT_EQ(order(R"({"command":"trial","um":10})", first).status, 202);
  EXPECT_EQ(order(go_on, second).status, 409);
  EXPECT_EQ(order(go_on, first).body, "{\"goes_on\":true}\n");
  ASSERT_EQ(given_.size(), 2U);
  EXPECT_EQ(given_[0].code, trial_begins);
  EXPECT_DOUBLE_EQ(given_[0].trial_m, 1e-5);
  EXPECT_EQ(given_[1].code, trial_goes_on);
  for (int minute = 0; minute < 15; ++minute) {
    order(go_on, first);
    clock_.now += 60 * ns_per_s;
  }
  EXPECT_EQ(order(go_on, first).status, 401);
  const std::string third = cookie_of(log_in("correct horse"));
  EXPECT_EQ(order(R"({"command":"trial","um":5})", third).status, 202);
  EXPECT_EQ(order(R"({"command":"trial","value":"end"})", third).status, 202);
  EXPECT_EQ(given_.back().code, trial_ends);
  EXPECT_EQ(order(go_on, third).status, 409);
}

TEST_F(PageOrders, a_logout_ends_the_trial_of_its_session_and_of_no_other) {
  const std::string first = cookie_of(log_in("correct horse")), second = cookie_of(log_in("correct horse"));
  order(R"({"command":"trial","um":10})", first);
  EXPECT_EQ(made(commands_->log_out(post("", second))).status, 200);
  EXPECT_EQ(given_.size(), 1U);
  const Page out = made(commands_->log_out(post("", first)));
  EXPECT_EQ(out.status, 200);
  EXPECT_NE(out.cookie.find("Max-Age=0"), std::string::npos);
  ASSERT_EQ(given_.size(), 2U);
  EXPECT_EQ(given_[1].kind, OrderKind::trial);
  EXPECT_EQ(given_[1].code, trial_ends);
  EXPECT_EQ(given_[1].id, 0) << "nobody has ordered it";
}

TEST_F(PageOrders, numbers_of_orders_go_from_60001_to_65534_and_begin_anew) {
  const Logged log;
  const std::string cookie = cookie_of(log_in("correct horse"));
  for (int id = 60001; id <= 65534; ++id) {
    EXPECT_EQ(order(tare_, cookie).status, 202);
    ASSERT_EQ(given_.back().id, id);
  }
  order(tare_, cookie);
  EXPECT_EQ(given_.back().id, 60001);
}

TEST_F(PageOrders, a_session_is_known_by_its_cookie_wherever_it_stands_among_others) {
  const std::string cookie = cookie_of(log_in("correct horse"));
  for (const std::string& cookies : {cookie, cookie + ";x=1", "x=1;" + cookie, "x=1; y=2; " + cookie + "; z=3"}) {
    EXPECT_EQ(order(tare_, cookies).status, 202) << cookies;
  }
  for (const std::string& cookies : {"x" + cookie, "x=" + cookie, cookie + "0", cookie.substr(1)}) {
    EXPECT_EQ(order(tare_, cookies).status, 401) << cookies;
  }
}

TEST_F(PageOrders, who_orders_what_from_where_is_said_in_the_log) {
  const Logged log;
  const std::string cookie = cookie_of(log_in("correct horse"));
  log_in("guess", "bert");
  made(commands_->command(post(tare_, cookie), {"left", outputs_, give_}));
  has_room_ = false;
  order(tare_, cookie);
  made(commands_->log_out(post("", cookie)));
  EXPECT_EQ(log.text(),
            "warning http: anna logged in from 127.0.0.1\n"
            "warning http: login as nobody known from 127.0.0.1 refused\n"
            "warning http: left: anna at 127.0.0.1: tare take, order 60001\n"
            "warning http: anna at 127.0.0.1: tare take: not taken, the queue of orders is full\n"
            "warning http: anna logged out from 127.0.0.1\n");
}

TEST_F(PageOrders, of_two_trials_of_one_session_each_spindle_has_its_own_end) {
  const std::string cookie = cookie_of(log_in("correct horse"));
  const std::string begin = R"({"command":"trial","um":1})", end = R"({"command":"trial","value":"end"})";
  for (const char* spindle : {"left", "right"}) {
    EXPECT_EQ(made(commands_->command(post(begin, cookie), {spindle, outputs_, give_})).status, 202);
  }
  EXPECT_EQ(made(commands_->command(post(end, cookie), {"left", outputs_, give_})).status, 202);
  const std::string go_on = R"({"command":"trial","value":"go_on"})";
  EXPECT_EQ(made(commands_->command(post(go_on, cookie), {"left", outputs_, give_})).status, 409);
  EXPECT_EQ(made(commands_->command(post(go_on, cookie), {"right", outputs_, give_})).status, 200);
  has_room_ = false;
  EXPECT_EQ(made(commands_->command(post(go_on, cookie), {"right", outputs_, give_})).status, 503);
}

}  // namespace show_page_commands_test
}  // namespace spindle_twin::firmware
