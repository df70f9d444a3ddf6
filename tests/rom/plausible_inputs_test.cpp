#include "rom/boundary_values/plausible_inputs.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <tuple>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::rom::tests {
namespace plausible_inputs_test {

Network motor_spindle() { return read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml"); }

std::vector<std::string> fields(const std::vector<Implausible>& found) {
  std::vector<std::string> names;
  for (const Implausible& each : found) names.push_back(each.field);
  return names;
}

std::vector<std::string> fields_of(const Boundaries& boundaries, const OperatingState& state) {
  return fields(implausible_inputs(boundaries, plausible_inputs(boundaries), state));
}

TEST(PlausibleInputs, the_operating_state_of_every_description_is_believed) {
  const Boundaries boundaries = motor_spindle().boundaries;
  EXPECT_TRUE(fields_of(boundaries, boundaries.operating).empty());
}

TEST(PlausibleInputs, percent_kelvin_and_ten_times_the_speed_are_not_believed) {
  const Boundaries boundaries = motor_spindle().boundaries;
  OperatingState state = boundaries.operating;
  state.load = 70.0;
  EXPECT_EQ(fields_of(boundaries, state), std::vector<std::string>{"load"});
  state = boundaries.operating;
  state.environment_K[0] = 295.0 + zero_degC_K;
  EXPECT_EQ(fields_of(boundaries, state), std::vector<std::string>{boundaries.environments[0].name + "_degC"});
  state = boundaries.operating;
  state.speed_rpm = 10.0 * boundaries.reference_speed_rpm;
  EXPECT_EQ(fields_of(boundaries, state), std::vector<std::string>{"speed_rpm"});
  EXPECT_TRUE(implausible_inputs(boundaries, plausible_inputs(boundaries, 5.0 * boundaries.reference_speed_rpm), state)
                  .empty());
}

TEST(PlausibleInputs, the_message_says_what_is_believed_and_which_mistake_it_may_be) {
  const Boundaries boundaries = motor_spindle().boundaries;
  OperatingState state = boundaries.operating;
  state.load = 70.0;
  EXPECT_EQ(implausible_inputs(boundaries, plausible_inputs(boundaries), state).front().message,
            "70 is not plausible; believed is -3 to 3 as a share of the rated load, 1 and not 100 when it is full");
}

TEST(PlausibleInputs, limits_follow_the_description_and_none_follows_a_zero) {
  Boundaries boundaries;
  boundaries.environments = {{"water", EnvironmentKind::coolant}, {"air", EnvironmentKind::ambient}};
  boundaries.operating.environment_K = Eigen::Vector2d(300.0, 295.0);
  boundaries.circuits.resize(2);
  boundaries.operating.flow_kg_per_s = Eigen::Vector2d(-0.1, 0.0);
  const PlausibleInputs believed = plausible_inputs(boundaries);
  EXPECT_EQ(believed.environment_K[0].min, 275.0);
  EXPECT_EQ(believed.environment_K[1].max, 325.0);
  EXPECT_EQ(believed.flow_kg_per_s[0].max, 0.5);
  EXPECT_FALSE(is_allowed(believed.flow_kg_per_s[0], -0.6));
  EXPECT_TRUE(is_allowed(believed.flow_kg_per_s[1], 1e9));
  EXPECT_TRUE(is_allowed(believed.speed_rpm, 1e9));
}

TEST(PlausibleDescription, heat_that_no_spindle_of_that_size_has_is_named) {
  const Network network = motor_spindle();
  const double capacity_J_per_K = network.capacity_J_per_K.sum();
  EXPECT_TRUE(implausible_description(network.boundaries, capacity_J_per_K).empty());
  Boundaries hot = network.boundaries;
  for (HeatSource& source : hot.sources) source.nominal_W = 2.0 * capacity_J_per_K;
  EXPECT_EQ(fields(implausible_description(hot, capacity_J_per_K)), std::vector<std::string>{"source"});
}

TEST(PlausibleDescription, a_film_and_a_contact_in_another_unit_are_named) {
  const Network network = motor_spindle();
  Boundaries wrong = network.boundaries;
  for (Conductance& conductance : wrong.conductances) conductance.nominal_W_per_m2K *= 1e6;
  const std::vector<Implausible> found = implausible_description(wrong, network.capacity_J_per_K.sum());
  ASSERT_FALSE(found.empty());
  for (const Implausible& each : found) {
    EXPECT_TRUE(each.field.starts_with("film ") || each.field.starts_with("contact ")) << each.field;
  }
}

TEST(PlausibleRanges, what_the_description_says_takes_the_place_of_every_default) {
  Boundaries own = motor_spindle().boundaries;
  const Environment& first = own.environments.front();
  own.plausible = {{"speed_rpm", between(0.0, 7.0)},
                   {"load", between(0.0, 100.0)},
                   {plausible_temperature_prefix + first.name, between(1.0, 600.0)},
                   {"film_W_per_m2K", between(1.0, 2.0)},
                   {"heat_W", between(0.0, 1.0)},
                   {"result_K", between(1.0, 1e6)}};
  OperatingState state = own.operating;
  state.load = 70.0;
  state.environment_K[0] = 295.0 + zero_degC_K;
  EXPECT_EQ(fields_of(own, state), std::vector<std::string>{"speed_rpm"});
  EXPECT_TRUE(implausible_temperatures(own, 2.0, zero_degC_K + 255225.0).empty());
  const std::vector<std::string> described = fields(implausible_description(own, 1e9));
  EXPECT_EQ(described.back(), "source");
  EXPECT_TRUE(described.front().starts_with("film ")) << described.front();
  own.plausible = {{"heat_W", between(1e8, 2e8)}};
  EXPECT_EQ(fields(implausible_description(own, 1e9)), std::vector<std::string>{"source"}) << "less than is believed";
}

constexpr const char* own_ranges =
    "\n[plausible]\nspeed_rpm = [0, 9000]\nresult_degC = [-5, 90]\ntemperatures_degC = { ROOM = [10, 35] }\n";

/// The text of the motor spindle with own_ranges, `from` in them replaced.
std::string described(const std::string& from = {}, const std::string& to = {}) {
  std::ifstream stream(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml");
  std::ostringstream text;
  text << stream.rdbuf();
  std::string ranges = own_ranges;
  ranges.replace(ranges.find("ROOM"), 4, motor_spindle().boundaries.environments.front().name);
  if (!from.empty()) ranges.replace(ranges.find(from), from.size(), to);
  return text.str() + ranges;
}

TEST(PlausibleRanges, go_from_the_description_into_the_network_file_and_back) {
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path = folder.file("plausible_ranges.rom");
  write_network(parse_by_hand(described(), "own.toml"), path);
  const Boundaries read = read_network(path).boundaries;
  ASSERT_EQ(read.plausible.size(), 3U);
  const PlausibleInputs believed = plausible_inputs(read);
  EXPECT_EQ(believed.speed_rpm.max, 9000.0);
  EXPECT_EQ(believed.environment_K.front().min, 10.0 + zero_degC_K);
  EXPECT_EQ(fields(implausible_temperatures(read, zero_degC_K, zero_degC_K + 91.0)),
            std::vector<std::string>{"hottest temperature"});
}

TEST(PlausibleRanges, one_number_twice_is_a_range_that_believes_that_number_only) {
  const Boundaries own = parse_by_hand(described("[0, 9000]", "[9000, 9000]"), "own.toml").boundaries;
  OperatingState state = own.operating;
  for (const double speed_rpm : {9000.0, 8999.0}) {
    state.speed_rpm = speed_rpm;
    EXPECT_EQ(fields_of(own, state).empty(), speed_rpm == 9000.0) << speed_rpm;
  }
}

TEST(PlausibleRanges, a_range_upside_down_and_an_unknown_name_are_refused_with_their_line) {
  for (const auto& [from, to, names] : {std::tuple{"[0, 9000]", "[9000, 0]", "plausible.speed_rpm"},
                                        std::tuple{"result_degC", "results", "plausible.results"},
                                        std::tuple{"temperatures_degC = { ", "temperatures_degC = { attic = [0, 1], ",
                                                   "plausible.temperatures_degC.attic"}}) {
    try {
      parse_by_hand(described(from, to), "own.toml");
      FAIL() << names << " was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(names), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("own.toml:"), std::string::npos) << error.what();
    }
  }
}

TEST(PlausibleTemperatures, are_those_that_grease_and_windings_live_at) {
  const Boundaries boundaries;
  EXPECT_TRUE(implausible_temperatures(boundaries, zero_degC_K - 10.0, zero_degC_K + 180.0).empty());
  EXPECT_EQ(fields(implausible_temperatures(boundaries, zero_degC_K, zero_degC_K + 255225.0)),
            std::vector<std::string>{"hottest temperature"});
  EXPECT_EQ(fields(implausible_temperatures(boundaries, 1.0, zero_degC_K)),
            std::vector<std::string>{"coldest temperature"});
}

}  // namespace plausible_inputs_test
}  // namespace spindle_twin::rom::tests
