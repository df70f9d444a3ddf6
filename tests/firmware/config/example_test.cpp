#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {
namespace config_example_test {

/// A key of the commented example, whether it is commented out or not: "gate = 5.0   # default; ...".
struct ExampleKey {
  std::string key, value, comment;
};

/// The keys below the line that begins with `heading`, perhaps behind "# ", up to the next table.
std::vector<ExampleKey> example_keys(const std::string& heading) {
  static const std::regex table(R"((# )?\[.*\].*)"), key(R"((?:# )?(\w+) = (\S+)\s+# default(?:; (.*))?)");
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/firmware/spindle-twind.example.toml");
  std::vector<ExampleKey> keys;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.find(heading) <= 2) {  // npos is greater
      inside = true;
      continue;
    }
    if (line.starts_with("# For law") || std::regex_match(line, table)) inside = false;
    std::smatch match;
    if (inside && std::regex_match(line, match, key)) keys.push_back({match[1], match[2], match[3]});
  }
  return keys;
}

/// Compares each option with the example, and remembers its key.
struct Compare {
  std::string heading;
  std::vector<ExampleKey> keys = example_keys(heading);
  std::set<std::string> declared = {};

  template <class Value>
  void operator()(const rom::Option& option, Value value) {
    const std::string key(option.key), doc(option.doc);
    declared.insert(key);
    std::string wanted = fmt::format("{} = {}", key, value);
    if constexpr (!std::is_same_v<Value, bool>) wanted = fmt::format("{} = {}", key, value - option.written_as_0);
    wanted += "   # default" + (doc.empty() ? "" : "; " + doc);
    for (const ExampleKey& shown : keys) {
      if (shown.key != key) continue;
      if constexpr (std::is_same_v<Value, bool>) {
        EXPECT_EQ(shown.value, value ? "true" : "false") << heading << ": must be: " << wanted;
      } else {
        EXPECT_DOUBLE_EQ(std::strtod(shown.value.c_str(), nullptr), value - option.written_as_0)
            << heading << ": must be: " << wanted;
      }
      EXPECT_EQ(shown.comment, doc) << heading << ": must be: " << wanted;
      return;
    }
    ADD_FAILURE() << heading << ": the example lacks: " << wanted;
  }
};

/// Every option of a struct stands in the example with its default and its meaning, and there is no other key than
/// these and `besides`.
template <class Options>
void expect_shown(const std::string& heading, const std::set<std::string>& besides = {}) {
  Compare compare{heading};
  const Options options;
  Options::each(options, compare);
  for (const ExampleKey& shown : compare.keys) {
    EXPECT_TRUE(compare.declared.contains(shown.key) || besides.contains(shown.key))
        << heading << ": there is no option " << shown.key;
  }
}

TEST(Example, shows_every_option_of_a_correction_and_of_health_with_its_default_and_meaning) {
  expect_shown<correction::EstimatorOptions>("[correction]", {"law", "enabled"});
  expect_shown<correction::EstimatorPriors>("[correction.prior]  ");
  expect_shown<correction::DriftOptions>("[correction.drift]");
  expect_shown<correction::PaperOptions>("For law = \"none\" only");
  expect_shown<correction::PaperGuards>("[correction.guards]");
  expect_shown<correction::HealthLimits>("[health] ", {"enabled", "return_within_K"});
  expect_shown<correction::TareLimits>("[health.tare] ", {"reference"});
}

/// What the example calls a default, as the text of one table; without, a comment in each line's place.
std::string table_of_defaults(const std::string& heading, bool with_values, const std::string& but = "") {
  std::string text;
  for (const ExampleKey& key : example_keys(heading)) {
    if (key.key == but) continue;
    text += with_values ? key.key + " = " + key.value + "\n" : "# left out\n";
  }
  EXPECT_FALSE(text.empty()) << heading;
  return text;
}

/// A small configuration with each of these tables; the example's own port of a device is none of its defaults.
Config configured(bool with_values) {
  const auto table = [&](const char* heading) { return table_of_defaults(heading, with_values); };
  return parse_config(
      "network = \"small.rom\"\n[cycle]\n" + table("[cycle]") + "[serve]\n" + table("[serve]") + "[http]\n" +
          table("# [http]") + "[plant]\nhost = \"h\"\nnode = \"n\"\n" + table("# [plant]") + "[device]\n" +
          table("name = \"cabinet\"") + "[[sensor]]\nkey_point = \"k\"\nregister = 0\n" + table("[[sensor]]") +
          "[[displacement]]\noutput = \"nose\"\nregister = 10\nsd_um = 1.0\n" + table("# [[displacement]]") +
          "[signals]\nspeed = { source = \"plc\" }\nload = { source = \"plc\" }\n" +
          "coolant = { source = \"plc\" }\nambient = { source = \"plc\" }\n[output]\n" + table("[output]") +
          "[compensation]\n" + table("[compensation]") + "[start]\n" + table("[start]") +
          "[history]\npath = \"h.csv\"\n" + table_of_defaults("# [history]", with_values, "most_days") +
          "[checkpoint]\npath = \"c\"\n" + table("# [checkpoint]"),
      "/etc/twin.toml");
}

std::vector<double> numbers_of_cycle(const CyclePlan& plan) {
  const CompensationPlan& to_machine = plan.compensation;
  const ProbePlan& probe = plan.probes[0];
  return {plan.period_s,
          plan.clock_rate,
          static_cast<double>(plan.compare_uncorrected),
          plan.plc_timeout_s,
          plan.slew_m_per_s,
          plan.start_wait_s,
          static_cast<double>(to_machine.enabled),
          to_machine.sign,
          to_machine.slew_m_per_s,
          to_machine.step_m,
          static_cast<double>(to_machine.on_loss == OnLoss::decay),
          to_machine.hold_s,
          to_machine.decay_s,
          to_machine.reference_m,
          plan.forecast.ahead_s,
          plan.forecast.settled_m,
          probe.interval_s};
}

TEST(Example, what_it_calls_a_default_is_what_a_key_left_out_means) {
  const Config said = configured(true), silent = configured(false);
  EXPECT_EQ(said.serve, silent.serve);
  EXPECT_EQ(said.show, silent.show);
  EXPECT_EQ(said.plant, silent.plant);
  EXPECT_EQ(said.keep, silent.keep);
  EXPECT_EQ(said.history, silent.history);
  EXPECT_EQ(numbers_of_cycle(said.cycle), numbers_of_cycle(silent.cycle));
  const auto of_sensor = [](const ConfiguredSensor& sensor) {
    return std::vector<double>{sensor.min_degC, sensor.max_degC, sensor.stale_after_s, sensor.interval_s};
  };
  EXPECT_EQ(of_sensor(said.sensors.at(0)), of_sensor(silent.sensors.at(0)));
  const auto of_probe = [](const ProbePlan& plan) {
    return std::vector<double>{plan.min_m, plan.max_m, plan.interval_s, plan.stale_after_s};
  };
  EXPECT_EQ(of_probe(said.probes.at(0).plan), of_probe(silent.probes.at(0).plan));
  const auto of_device = [](const DevicePlan& plan) {
    return std::vector<double>{plan.poll_s, plan.delay_s, plan.retry_s, plan.retry_most_s};
  };
  EXPECT_EQ(of_device(said.devices.at(0)), of_device(silent.devices.at(0)));
}

}  // namespace config_example_test
}  // namespace spindle_twin::firmware
