#include <gtest/gtest.h>

#include <cmath>

#include "firmware/config/config.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace config_limits_test {

constexpr double at_rest_K = 300.15;  // of the description's coolant and ambient

SpindlePlan plan_of(const std::string& signals, const std::string& more = "") {
  const std::string text =
      "network = \"x.rom\"\n[serve]\nport = 1502\n[device]\nport = 1503\n[start]\ntemperature_degC = "
      "20.0\n[signals]\n" +
      signals + more;
  return bind_config(parse_config(text, "/etc/twin.toml"), tests::small_network());
}

const std::string told =
    "speed = { source = \"plc\" }\nload = { source = \"plc\" }\n"
    "coolant = { source = \"device\", register = 0 }\nambient = { source = \"plc\" }\n";

std::string error_of(const std::string& signals, const std::string& more = "") {
  return tests::refusal_of([&] { plan_of(signals, more); });
}

TEST(Limits, signals_that_are_told_are_believed_near_what_the_description_says) {
  const auto signals = plan_of(told).cycle.signals;
  EXPECT_EQ(signals[0].max, 12000.0);
  EXPECT_EQ(signals[0].min, -12000.0);
  EXPECT_EQ(signals[1].max, 3.0);
  EXPECT_DOUBLE_EQ(signals[2].min, at_rest_K - 25.0);
  EXPECT_DOUBLE_EQ(signals[2].max, at_rest_K + 25.0);
  EXPECT_EQ(signals[2].most_per_s, 2.0);
  EXPECT_DOUBLE_EQ(signals[3].max, at_rest_K + 30.0);
  EXPECT_EQ(signals[3].most_per_s, 0.5);
}

TEST(Limits, the_configuration_has_the_last_word) {
  const auto signals =
      plan_of(
          "speed = { source = \"plc\", max = 18000.0, max_per_s = 4000.0 }\nload = { source = \"plc\", min = 0.0 }\n"
          "coolant = { source = \"constant\", value = 80.0 }\n"
          "ambient = { source = \"plc\", min = -40.0, max = 15.0, max_per_s = 1.0 }\n")
          .cycle.signals;
  EXPECT_EQ(signals[0].max, 18000.0);
  EXPECT_EQ(signals[0].min, -12000.0);
  EXPECT_EQ(signals[0].most_per_s, 4000.0);
  EXPECT_EQ(signals[1].min, 0.0);
  EXPECT_EQ(signals[1].max, 3.0);
  EXPECT_GT(signals[2].max, 353.15) << "a constant is believed";
  EXPECT_DOUBLE_EQ(signals[3].min, 233.15);
  EXPECT_DOUBLE_EQ(signals[3].max, 288.15);
}

TEST(Limits, a_wrong_limit_names_file_line_and_field) {
  EXPECT_EQ(error_of("speed = { source = \"plc\", min = 5.0, max = 5.0 }\n" + told.substr(told.find("load"))),
            "/etc/twin.toml:9: signals.speed.max: must be above min");
  EXPECT_EQ(
      error_of(told, "[output]\nlimit_um = { noose = 5.0 }\n"),
      "/etc/twin.toml:14: output.limit_um.noose: the network has no deformation output \"noose\"; it has nose, rear");
  EXPECT_EQ(error_of(told, "[output]\nlimit_um = 0\n"),
            "/etc/twin.toml:14: output.limit_um: must be a number from 0 (excluded) to 10000, is 0");
}

TEST(Limits, outputs_have_limits_by_default_of_all_or_one_by_one) {
  const rom::Network network = tests::small_network();
  const double norm = network.deformations[1].row_m_per_K.lpNorm<1>();
  EXPECT_DOUBLE_EQ(plan_of(told).cycle.output_limit_m[1], 200.0 * norm);
  EXPECT_DOUBLE_EQ(plan_of(told, "[output]\nlimit_um = 50.0\n").cycle.output_limit_m[0], 5e-5);
  const CyclePlan one = plan_of(told, "[output]\nlimit_um = { nose = 60.0 }\n").cycle;
  EXPECT_DOUBLE_EQ(one.output_limit_m[0], 6e-5);
  EXPECT_DOUBLE_EQ(one.output_limit_m[1], 200.0 * norm);
}

TEST(Limits, of_the_server_and_of_a_silent_plc) {
  const auto config = [](const std::string& serve) {
    return parse_config("network = \"x.rom\"\n[serve]\n" + serve +
                            "[start]\ntemperature_degC = 20.0\n[signals]\nspeed = { source = \"plc\" }\nload "
                            "= { source = \"plc\" }\ncoolant = { source = \"plc\" }\nambient = { source = "
                            "\"plc\" }\n",
                        "x.toml");
  };
  const auto plan = [&](const std::string& serve) { return bind_config(config(serve), tests::small_network()); };
  EXPECT_EQ(plan("").cycle.plc_timeout_s, 10.0) << "on by default";
  EXPECT_EQ(config("").serve.idle_s, 300.0);
  EXPECT_EQ(config("").serve.connections_per_host, 16);
  const std::string own = "plc_timeout_s = 0\nidle_s = 60\nconnections_per_host = 2\n";
  EXPECT_EQ(plan(own).cycle.plc_timeout_s, 0.0);
  EXPECT_EQ(config(own).serve.idle_s, 60.0);
  EXPECT_EQ(config(own).serve.connections_per_host, 2);
}

TEST(Limits, deviations_are_nothing_at_all_or_what_a_covariance_can_hold) {
  const std::string sensor = "[[sensor]]\nkey_point = \"sleeve_inner\"\nregister = 8\n";
  for (const char* key : {"heat", "contact", "film", "environment_K", "bearing_per_K", "speed_exponent", "start_K",
                          "start_shape_K", "disturbance"}) {
    const auto with = [&](const char* value) {
      return error_of(told, sensor + "[correction.prior]\n" + key + " = " + value + "\n");
    };
    EXPECT_EQ(with("1e-200"),
              "/etc/twin.toml:17: correction.prior." + std::string(key) + ": must be 0 or at least 1e-9");
    EXPECT_EQ(with("0.0"), "accepted");
  }
}

}  // namespace config_limits_test
}  // namespace spindle_twin::firmware
