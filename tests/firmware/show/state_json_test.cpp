#include "firmware/show/state_json.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "firmware/show/shown_values.hpp"
#include "tests/firmware/support/small_network.hpp"

/// The JSON says what the registers hold, and nothing else.
namespace spindle_twin::firmware {
namespace show_state_json_test {

using nlohmann::json;

/// A snapshot with values, with codes and bits that are set, and with much that is not present.
RegisterImage some_image() {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.state = State::degraded;
  snapshot.quality = bits(Quality::sensor_failed) | bits(Quality::device_offline);
  snapshot.fault = bits(Fault::history_lost);
  snapshot.nose_m = -12.5e-6;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) snapshot.predicted_K[k] = 300.15 + static_cast<double>(k);
  snapshot.health_watched = true;
  snapshot.sensor_quality.fill(SensorQuality::good);
  snapshot.sensor_health[1] = {SensorState::failed, SensorFault::drift};
  snapshot.sequence = 61034ULL * 65536 + 65535;
  RegisterImage image{};
  fill_image(snapshot, snapshot.time_ns + 1'500'000'000, image);
  return image;
}

void expect_number(const json& shown, double held, const RegisterEntry& entry) {
  if (std::isnan(held)) {
    EXPECT_TRUE(shown.is_null()) << entry.name << ": " << shown;
    return;
  }
  ASSERT_TRUE(shown.is_number()) << entry.name << ": " << shown;
  EXPECT_NEAR(shown.get<double>(), held, 1e-6 * std::max(1.0, std::abs(held))) << entry.name;
}

TEST(StateJson, holds_each_register_that_is_read_with_its_value_and_unit_and_no_command) {
  const RegisterImage image = some_image();
  const ShownNames names = names_of(tests::small_network());
  const json all = json::parse(state_json(image, names));
  EXPECT_EQ(all["spindle"], names.spindle);
  EXPECT_EQ(all["map_version"], register_map_version);
  const json& registers = all["registers"];
  std::size_t shown = 0;
  for (std::size_t r = 0; r < register_entries.size(); ++r) {
    const RegisterEntry& entry = register_entries[r];
    const auto which = static_cast<Register>(r);
    EXPECT_EQ(registers.contains(entry.name), !entry.command) << entry.name;
    if (entry.command) continue;
    ++shown;
    const json& one = registers[entry.name];
    EXPECT_EQ(one.value("unit", ""), entry.unit) << entry.name;
    if (entry.slots == 1) {
      expect_number(one["value"], shown_value(image, which, 0), entry);
      continue;
    }
    const std::vector<std::string>* slots = names.of(entry.slot_names);
    const json& values = one["values"];
    ASSERT_EQ(values.size(), slots != nullptr ? std::min<std::size_t>(slots->size(), entry.slots) : entry.slots);
    for (std::size_t slot = 0; slot < values.size(); ++slot) {
      const json& value = slots != nullptr ? values[(*slots)[slot]] : values[slot];
      expect_number(value, shown_value(image, which, static_cast<int>(slot)), entry);
    }
  }
  EXPECT_EQ(registers.size(), shown);
}

TEST(StateJson, codes_have_their_name_and_bits_the_names_of_those_that_are_set) {
  const json all = json::parse(state_json(some_image(), names_of(tests::small_network())));
  const json& registers = all["registers"];
  EXPECT_EQ(registers["state"]["name"], "degraded");
  EXPECT_EQ(registers["quality"]["set"], (json{"device_offline", "sensor_failed"}));
  EXPECT_EQ(registers["fault"]["set"], json{"history_lost"});
  EXPECT_FALSE(registers["state"].contains("set"));
  EXPECT_FALSE(registers["fault"].contains("name"));
  EXPECT_FALSE(registers["nose_int16"].contains("name"));
  const json& sensors = registers["sensor_state"]["names"];
  EXPECT_EQ(sensors["sleeve_middle"], "failed");
  EXPECT_EQ(sensors["sleeve_inner"], "good");
}

TEST(StateJson, numbers_have_the_digits_that_their_register_resolves) {
  const std::string text = state_json(some_image(), names_of(tests::small_network()));
  EXPECT_NE(text.find("\"nose_int16\":{\"value\":-12.5,"), std::string::npos);
  EXPECT_NE(text.find("\"heartbeat\":{\"value\":65535"), std::string::npos) << "uses all 16 bits";
  EXPECT_NE(text.find("\"sequence\":{\"value\":3999989759"), std::string::npos);
}

}  // namespace show_state_json_test
}  // namespace spindle_twin::firmware
