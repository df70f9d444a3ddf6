#include "firmware/config/implausible_plan.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/firmware/support/small_network.hpp"

/// What --check says of constants that no machine of this network has.
namespace spindle_twin::firmware {
namespace config_implausible_plan_test {

rom::Network with_circuits() {
  rom::Network network = tests::small_network();
  network.boundaries.circuits = {{"jacket", 0, 4180.0, {2}}, {"cover", 0, 4180.0, {3}}};
  network.boundaries.operating.flow_kg_per_s = Eigen::Vector2d(0.1, 0.2);
  return network;
}

/// Field and line of each finding. Of the signals, from line 7 on, `which` is as given.
std::vector<std::string> found(const std::string& which, const std::string& is, rom::Network network = with_circuits(),
                               const std::string& start = "temperature_degC = 20.0") {
  std::string text = "network = \"x.rom\"\n[serve]\nport = 1502\n[start]\n" + start + "\n[signals]\n";
  for (const auto& [name, usual] :
       std::vector<std::pair<std::string, std::string>>{{"speed", "source = \"constant\", value = 6000.0"},
                                                        {"load", "source = \"constant\", value = 1.0"},
                                                        {"coolant", "source = \"constant\", value = 27.0"},
                                                        {"ambient", "source = \"constant\", value = 27.0"},
                                                        {"flow.jacket", "source = \"constant\", value = 0.1"},
                                                        {"flow.cover", "source = \"constant\", value = 0.2"}}) {
    text.append(name).append(" = { ").append(name == which ? is : usual).append(" }\n");
  }
  const Config config = parse_config(text, "/etc/twin.toml");
  std::vector<std::string> said;
  for (const rom::InputError& each : implausible_plan(config, network, bind_config(config, network).cycle)) {
    const std::string what = each.what();
    said.push_back(what.substr(0, what.find(": ", what.find(": ") + 2)));
  }
  return said;
}

TEST(ImplausiblePlan, each_constant_is_named_at_its_line_and_no_other_is) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(found("", ""), Lines{});
  const auto constant = [](const std::string& value) { return "source = \"constant\", value = " + value; };
  EXPECT_EQ(found("speed", constant("50000.0")), Lines{"/etc/twin.toml:7: signals.speed"});
  EXPECT_EQ(found("load", constant("9.0")), Lines{"/etc/twin.toml:8: signals.load"});
  EXPECT_EQ(found("coolant", constant("90.0")), Lines{"/etc/twin.toml:9: signals.coolant"});
  EXPECT_EQ(found("ambient", constant("-40.0")), Lines{"/etc/twin.toml:10: signals.ambient"});
  EXPECT_EQ(found("flow.jacket", constant("5.0")), Lines{"/etc/twin.toml:11: signals.flow.jacket"});
  EXPECT_EQ(found("flow.cover", constant("5.0")), Lines{"/etc/twin.toml:12: signals.flow.cover"});
}

TEST(ImplausiblePlan, of_what_the_machine_tells_the_first_value_is_judged) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(found("speed", "source = \"plc\", first = 50000.0"), Lines{"/etc/twin.toml:7: signals.speed"});
  EXPECT_EQ(found("coolant", "source = \"plc\", first = 293.15"), Lines{"/etc/twin.toml:9: signals.coolant"});
  EXPECT_EQ(found("coolant", "source = \"plc\", first = 25.0"), Lines{});
  EXPECT_EQ(found("coolant", "source = \"plc\", first = 75.0, max = 80.0"), Lines{});
  EXPECT_EQ(found("coolant", "source = \"plc\""), Lines{}) << "the value before the first reading is not the user's";
}

TEST(ImplausiblePlan, a_start_in_kelvin_is_named) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(found("", "", with_circuits(), "temperature_degC = 293.15"),
            Lines{"/etc/twin.toml:5: start.temperature_degC"});
  EXPECT_EQ(found("", "", with_circuits(), "temperature_degC = { inner = 20.0, outer = 293.15 }"),
            Lines{"/etc/twin.toml:5: start.temperature_degC.outer"});
}

TEST(ImplausiblePlan, what_is_wrong_with_the_description_is_the_networks) {
  rom::Network network = with_circuits();
  network.boundaries.conductances[2].nominal_W_per_m2K = 1e9;
  EXPECT_EQ(found("", "", network), std::vector<std::string>{"/etc/x.rom: film coolant"});
}

}  // namespace config_implausible_plan_test
}  // namespace spindle_twin::firmware
