#include "correction/estimator/inputs_changed.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

namespace spindle_twin::correction {
namespace estimator_inputs_changed_test {

rom::OperatingState some_state() {
  rom::OperatingState state{6000.0, 0.5, Eigen::VectorXd::Constant(1, 300.15)};
  state.flow_kg_per_s = Eigen::Vector2d(0.05, 0.03);
  state.current_A = 10.0;
  state.heat_W = Eigen::Vector2d(120.0, 80.0);
  return state;
}

TEST(InputsChanged, of_motors_and_heats_that_tell_nothing_or_the_same_are_none) {
  rom::OperatingState state = some_state();
  state.heat_W[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(inputs_changed(state, state)) << "not told before, and not now";
  state.power_W = 900.0;
  rom::OperatingState now = state;
  now.power_W = 940.0;
  EXPECT_FALSE(inputs_changed(now, state));
  now.power_W = 950.0;
  EXPECT_TRUE(inputs_changed(now, state));
}

TEST(InputsChanged, ends_a_held_period_at_a_jump_and_not_at_noise) {
  struct Case {
    const char* what;
    std::function<void(rom::OperatingState&)> change;
    bool ends;
  };
  const std::vector<Case> cases = {
      {"nothing", [](rom::OperatingState&) {}, false},
      {"speed, 0.1 %", [](rom::OperatingState& now) { now.speed_rpm *= 1.001; }, false},
      {"speed, 1 %", [](rom::OperatingState& now) { now.speed_rpm *= 1.01; }, true},
      {"load, 0.005", [](rom::OperatingState& now) { now.load += 0.005; }, false},
      {"load, 0.009", [](rom::OperatingState& now) { now.load += 0.009; }, false},
      {"load, 0.011", [](rom::OperatingState& now) { now.load += 0.011; }, true},
      {"load, 0.02", [](rom::OperatingState& now) { now.load += 0.02; }, true},
      {"flow stops", [](rom::OperatingState& now) { now.flow_kg_per_s[0] = 0.0; }, true},
      {"current, 3 %", [](rom::OperatingState& now) { now.current_A = 10.3; }, false},
      {"current, 20 %", [](rom::OperatingState& now) { now.current_A = 12.0; }, true},
      {"current off", [](rom::OperatingState& now) { now.current_A = 0.0; }, true},
      {"current no longer told", [](rom::OperatingState& now) { now.current_A.reset(); }, true},
      {"power told", [](rom::OperatingState& now) { now.power_W = 0.0; }, true},
      {"speed, 0.19 %", [](rom::OperatingState& now) { now.speed_rpm *= 1.0019; }, false},
      {"speed, 0.21 %", [](rom::OperatingState& now) { now.speed_rpm *= 0.9979; }, true},
      {"other way round", [](rom::OperatingState& now) { now.speed_rpm *= -1.0; }, true},
      {"load, -0.011", [](rom::OperatingState& now) { now.load -= 0.011; }, true},
      {"flow, 0.19 %", [](rom::OperatingState& now) { now.flow_kg_per_s[0] *= 1.0019; }, false},
      {"flow, 0.21 %", [](rom::OperatingState& now) { now.flow_kg_per_s[0] *= 0.9979; }, true},
      {"second flow", [](rom::OperatingState& now) { now.flow_kg_per_s[1] *= 0.9979; }, true},
      {"current, 4.8 %", [](rom::OperatingState& now) { now.current_A = 10.48; }, false},
      {"current, 5.5 %", [](rom::OperatingState& now) { now.current_A = 10.55; }, true},
      {"measured heat, 4.8 %", [](rom::OperatingState& now) { now.heat_W[0] *= 1.048; }, false},
      {"measured heat, 5.5 %", [](rom::OperatingState& now) { now.heat_W[0] *= 1.055; }, true},
      {"second measured heat", [](rom::OperatingState& now) { now.heat_W[1] *= 1.055; }, true},
      {"measured heat no longer told",
       [](rom::OperatingState& now) { now.heat_W[1] = std::numeric_limits<double>::quiet_NaN(); }, true},
      {"surroundings", [](rom::OperatingState& now) { now.environment_K[0] += 5.0; }, false}};
  for (const Case& item : cases) {
    rom::OperatingState now = some_state();
    item.change(now);
    EXPECT_EQ(inputs_changed(now, some_state()), item.ends) << item.what;
    EXPECT_EQ(inputs_changed(some_state(), now), item.ends) << item.what << ", back";
  }
}

}  // namespace estimator_inputs_changed_test
}  // namespace spindle_twin::correction
