#include "rom/boundary_values/plausible_inputs.hpp"

#include <gtest/gtest.h>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/units.hpp"

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

TEST(PlausibleTemperatures, are_those_that_grease_and_windings_live_at) {
  EXPECT_TRUE(implausible_temperatures(zero_degC_K - 10.0, zero_degC_K + 180.0).empty());
  EXPECT_EQ(fields(implausible_temperatures(zero_degC_K, zero_degC_K + 255225.0)),
            std::vector<std::string>{"hottest temperature"});
  EXPECT_EQ(fields(implausible_temperatures(1.0, zero_degC_K)), std::vector<std::string>{"coldest temperature"});
}

}  // namespace plausible_inputs_test
}  // namespace spindle_twin::rom::tests
