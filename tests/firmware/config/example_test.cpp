#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {
namespace config_example_test {

/// A key of the commented example, whether it is commented out or not: "gate = 5.0   # default; ...".
struct ExampleKey {
  std::string key, value, comment;
};

/// The keys below the line that says `heading`, up to the next table.
std::vector<ExampleKey> example_keys(const std::string& heading) {
  static const std::regex table(R"((# )?\[.*\].*)"), key(R"((?:# )?(\w+) = (\S+)\s+# default(?:; (.*))?)");
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/firmware/spindle-twind.example.toml");
  std::vector<ExampleKey> keys;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.find(heading) != std::string::npos) {
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
  expect_shown<correction::PaperOptions>("For law = \"none\" only");
  expect_shown<correction::PaperGuards>("[correction.guards]");
  expect_shown<correction::HealthLimits>("[health] ", {"enabled", "return_within_K"});
  expect_shown<correction::TareLimits>("[health.tare] ", {"reference"});
}

}  // namespace config_example_test
}  // namespace spindle_twin::firmware
