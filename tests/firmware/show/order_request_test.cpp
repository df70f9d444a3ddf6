#include "firmware/show/order_request.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace spindle_twin::firmware {
namespace show_order_request_test {

const std::vector<std::string> outputs{"nose", "housing"};

std::string refusal(const std::string& body) {
  try {
    read_order(body, outputs);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(OrderRequest, words_are_the_numbers_that_a_plc_writes) {
  struct Case {
    const char* body;
    OrderKind kind;
    int code;
  };
  for (const Case& each : {Case{R"({"command":"tare","value":"take"})", OrderKind::tare, 1},
                           {R"({"command":"tare","value":"clear"})", OrderKind::tare, 2},
                           {R"({"command":"sensors","value":"tare"})", OrderKind::sensors, 1},
                           {R"({"command":"sensors","value":"clear_tare"})", OrderKind::sensors, 2},
                           {R"({"command":"sensors","value":"acknowledge"})", OrderKind::sensors, 3},
                           {R"({"command":"correction","value":"off"})", OrderKind::correction, 0},
                           {R"({"command":"compensation","value":"on"})", OrderKind::compensation, 1},
                           {R"({"command":"compensation","value":"as_configured"})", OrderKind::compensation, 65535},
                           {R"({"command":"acknowledge"})", OrderKind::acknowledge, 1}}) {
    const OrderRequest request = read_order(each.body, outputs);
    EXPECT_EQ(request.order.kind, each.kind) << each.body;
    EXPECT_EQ(request.order.code, each.code) << each.body;
    EXPECT_EQ(request.order.id, 0) << "whoever passes it on gives it a number";
  }
  EXPECT_EQ(read_order(R"({"command":"tare","value":"take"})", outputs).said, "tare take");
}

TEST(OrderRequest, a_length_is_of_the_output_that_is_named_and_else_of_the_first) {
  const Order nose = read_order(R"({"command":"length","um":-3.5,"sd_um":1})", outputs).order;
  EXPECT_EQ(nose.kind, OrderKind::length);
  EXPECT_EQ(nose.code, 1);
  EXPECT_EQ(nose.length.output, 0U);
  EXPECT_DOUBLE_EQ(nose.length.value_m, -3.5e-6);
  EXPECT_DOUBLE_EQ(nose.length.deviation_m, 1e-6);
  EXPECT_EQ(read_order(R"({"command":"length","um":0,"sd_um":1,"output":"housing"})", outputs).order.length.output, 1U);
}

TEST(OrderRequest, bad_bodies_get_one_error_that_says_what_is_allowed) {
  EXPECT_EQ(refusal(""), "the body must be a JSON object");
  EXPECT_EQ(refusal("[1]"), "the body must be a JSON object");
  EXPECT_EQ(refusal(R"({"command":"tare")"), "the body must be a JSON object");
  EXPECT_EQ(refusal(std::string(2000, '[')), "the body must be a JSON object");
  EXPECT_EQ(refusal("{}"),
            "command: must be one of tare, sensors, correction, compensation, length, trial, acknowledge");
  EXPECT_EQ(refusal(R"({"command":"reboot"})"),
            "command: must be one of tare, sensors, correction, compensation, length, trial, acknowledge");
  EXPECT_EQ(refusal(R"({"command":"tare"})"), "value: must be one of take, clear");
  EXPECT_EQ(refusal(R"({"command":"tare","value":1})"), "value: must be one of take, clear");
  EXPECT_EQ(refusal(R"({"command":"tare","value":"on"})"), "value: must be one of take, clear");
  EXPECT_EQ(refusal(R"({"command":"tare","value":"take","times":2})"), "there is no key \"times\" here");
  EXPECT_EQ(refusal(R"({"command":"length","um":"3"})"), "um: must be a number from -10000 to 10000");
  EXPECT_EQ(refusal(R"({"command":"length","um":1e9,"sd_um":1})"), "um: must be a number from -10000 to 10000");
  EXPECT_EQ(refusal(R"({"command":"length","um":3,"sd_um":0})"), "sd_um: must be a number from 0.01 to 1000");
  EXPECT_EQ(refusal(R"({"command":"length","um":3,"sd_um":1,"output":"tail"})"),
            "output: must be one of nose, housing");
  EXPECT_EQ(refusal(R"({"command":"trial"})"), "value: must be end or go_on, or um the value to try");
  EXPECT_EQ(refusal(R"({"command":"trial","value":"stop"})"), "value: must be end or go_on");
  EXPECT_EQ(refusal(R"({"command":"trial","um":51})"), "um: must be a number from -50 to 50");
  EXPECT_EQ(refusal(R"({"command":"trial","um":null})"), "um: must be a number from -50 to 50");
  EXPECT_EQ(refusal(R"({"command":"trial","um":10,"value":"end"})"), "there is no key \"value\" here");
}

TEST(OrderRequest, a_trial_has_a_value_or_ends_or_goes_on) {
  const OrderRequest begins = read_order(R"({"command":"trial","um":-10})", outputs);
  EXPECT_EQ(begins.order.kind, OrderKind::trial);
  EXPECT_EQ(begins.order.code, trial_begins);
  EXPECT_DOUBLE_EQ(begins.order.trial_m, -10e-6);
  EXPECT_EQ(begins.said, "trial -10 um");
  EXPECT_EQ(read_order(R"({"command":"trial","value":"end"})", outputs).order.code, trial_ends);
  EXPECT_EQ(read_order(R"({"command":"trial","value":"go_on"})", outputs).order.code, trial_goes_on);
}

TEST(OrderRequest, numbers_may_be_at_their_limits_and_not_beyond) {
  const auto length = [](const std::string& um, const std::string& sd_um) {
    return R"({"command":"length","um":)" + um + R"(,"sd_um":)" + sd_um + "}";
  };
  for (const char* um : {"-10000", "10000"}) EXPECT_EQ(refusal(length(um, "1")), "accepted") << um;
  for (const char* um : {"-10000.1", "10000.1"}) EXPECT_NE(refusal(length(um, "1")), "accepted") << um;
  for (const char* sd_um : {"0.01", "1000"}) EXPECT_EQ(refusal(length("1", sd_um)), "accepted") << sd_um;
  for (const char* sd_um : {"0.0099", "1000.1"}) EXPECT_NE(refusal(length("1", sd_um)), "accepted") << sd_um;
  const auto trial = [](const std::string& um) { return R"({"command":"trial","um":)" + um + "}"; };
  for (const char* um : {"-50", "50", "0"}) EXPECT_EQ(refusal(trial(um)), "accepted") << um;
  for (const char* um : {"-50.1", "50.1"}) EXPECT_NE(refusal(trial(um)), "accepted") << um;
}

std::string login_refusal(const std::string& body) {
  try {
    read_login(body);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LoginRequest, has_a_name_and_a_password_of_up_to_128_bytes_and_nothing_else) {
  const auto login = [](const std::string& user, std::size_t bytes, const std::string& more = "") {
    return R"({"user":")" + user + R"(","password":")" + std::string(bytes, 'x') + "\"" + more + "}";
  };
  const LoginRequest read = read_login(login("anna", 3));
  EXPECT_EQ(read.user, "anna");
  EXPECT_EQ(read.password, "xxx");
  EXPECT_EQ(login_refusal(login("anna", 128)), "accepted");
  EXPECT_EQ(login_refusal(login("anna", 129)), "password: must have at most 128 bytes");
  EXPECT_EQ(login_refusal(login("an na", 8)), "user: must be 1 to 32 letters, digits, '_', '-' or '.'");
  EXPECT_EQ(login_refusal(login("anna", 8, R"(,"x":1)")), "there is no key \"x\" here");
  EXPECT_EQ(login_refusal(R"({"user":"anna"})"), "password: must be a text");
}

}  // namespace show_order_request_test
}  // namespace spindle_twin::firmware
