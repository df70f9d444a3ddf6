#include <gtest/gtest.h>

#include <string>

#include "correction/health/record.hpp"
#include "correction/paper/paper_correction.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {
namespace cycle_codes_test {

template <std::size_t count>
std::string name_of(const std::array<CodeName, count>& codes, int value) {
  for (const CodeName& code : codes) {
    if (code.value == value) return code.name;
  }
  return "none of " + std::to_string(value);
}

// The cycle publishes the correction's own numbers, so each must be declared under the same name.

TEST(Codes, freezes_of_the_published_law_are_those_of_the_correction) {
  using correction::Freeze;
  const auto name = [](Freeze freeze) { return name_of(correction_freeze_codes, bits(freeze)); };
  EXPECT_EQ(name(Freeze::none), "none");
  EXPECT_EQ(name(Freeze::waiting), "waiting");
  EXPECT_EQ(name(Freeze::too_few_sensors), "too_few_sensors");
  EXPECT_EQ(name(Freeze::operating_changed), "operating_changed");
  EXPECT_EQ(name(Freeze::standstill), "standstill");
  EXPECT_EQ(name(Freeze::small_rise), "small_rise");
  EXPECT_EQ(name(Freeze::negative_ratio), "negative_ratio");
  EXPECT_EQ(name(Freeze::deadband), "deadband");
  EXPECT_EQ(name(Freeze::at_limit), "at_limit");
  EXPECT_EQ(name(Freeze::base_failed), "base_failed");
}

TEST(Codes, states_of_a_sensor_are_those_of_its_health) {
  using correction::HealthState;
  const auto name = [](HealthState state) { return name_of(sensor_state_codes, bits(state)); };
  EXPECT_EQ(name(HealthState::good), "good");
  EXPECT_EQ(name(HealthState::suspect), "suspect");
  EXPECT_EQ(name(HealthState::failed), "failed");
  EXPECT_EQ(name(HealthState::returning), "returning");
}

TEST(Codes, faults_of_a_sensor_are_those_of_its_health) {
  using correction::HealthFault;
  const auto name = [](HealthFault fault) { return name_of(sensor_fault_codes, bits(fault)); };
  EXPECT_EQ(name(HealthFault::none), "none");
  EXPECT_EQ(name(HealthFault::open), "open");
  EXPECT_EQ(name(HealthFault::shorted), "shorted");
  EXPECT_EQ(name(HealthFault::out_of_range), "out_of_range");
  EXPECT_EQ(name(HealthFault::jump), "jump");
  EXPECT_EQ(name(HealthFault::spikes), "spikes");
  EXPECT_EQ(name(HealthFault::stuck), "stuck");
  EXPECT_EQ(name(HealthFault::drift), "drift");
  EXPECT_EQ(name(HealthFault::swapped), "swapped");
  EXPECT_EQ(name(HealthFault::implausible), "implausible");
}

TEST(Codes, qualities_and_faults_are_single_bits) {
  for (const CodeName& code : quality_codes) EXPECT_EQ(code.value & (code.value - 1), 0) << code.name;
  for (const CodeName& code : fault_codes) EXPECT_EQ(code.value & (code.value - 1), 0) << code.name;
}

}  // namespace cycle_codes_test
}  // namespace spindle_twin::firmware
