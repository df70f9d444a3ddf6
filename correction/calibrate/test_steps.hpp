#pragma once

#include <vector>

#include "correction/calibrate/thermal_test.hpp"

namespace spindle_twin::correction {

/// Instants closer than this are one. [s]
inline constexpr double instant_slack_s = 1e-6;

/// A step of the model through a test, and what the log says of it.
struct TestStep {
  double begin_s = 0.0;
  double end_s = 0.0;
  rom::OperatingState operating;  ///< as read, mean over the step
};

/// The steps in which a test is integrated, from its first to its last instant without a gap. One ends where speed,
/// load, current, power, a flow or a measured heat changes (inputs_changed); from there on steps grow with a quarter of
/// the time since, from a twentieth of longest_step_s to longest_step_s, because what the change has set off is quick
/// at first. They follow from the log alone, so that a prediction is a smooth function of its parameters.
std::vector<TestStep> test_steps(const ThermalTest& test, double longest_step_s);

}  // namespace spindle_twin::correction
