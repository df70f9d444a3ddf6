#include "correction/calibrate/test_steps.hpp"

#include <algorithm>
#include <optional>

#include "correction/estimator/inputs_changed.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double shortest_share = 0.05;  // of the longest step
constexpr double growth_share = 0.25;    // of the time since the last change

void add(double share, const std::optional<double>& value, std::optional<double>& sum) {
  if (value && sum) *sum += share * *value;
}

/// sum += share · state. What is told in some of a step's instants only ends the step (inputs_changed).
void add(double share, const rom::OperatingState& state, rom::OperatingState& sum) {
  sum.speed_rpm += share * state.speed_rpm;
  sum.load += share * state.load;
  sum.environment_K += share * state.environment_K;
  sum.flow_kg_per_s += share * state.flow_kg_per_s;
  sum.heat_W += share * state.heat_W;
  add(share, state.current_A, sum.current_A);
  add(share, state.power_W, sum.power_W);
}

rom::OperatingState zero_of(const rom::OperatingState& state) {
  rom::OperatingState zero = state;
  zero.speed_rpm = zero.load = 0.0;
  zero.environment_K.setZero();
  zero.flow_kg_per_s.setZero();
  zero.heat_W.setZero();
  if (zero.current_A) zero.current_A = 0.0;
  if (zero.power_W) zero.power_W = 0.0;
  return zero;
}

/// Mean over [begin_s, end_s], `first` the instant from which on the inputs at begin_s hold.
rom::OperatingState mean_inputs(const ThermalTest& test, std::size_t first, double begin_s, double end_s) {
  rom::OperatingState mean = zero_of(test.operating[first]);
  double from_s = begin_s;
  for (std::size_t i = first; from_s < end_s; ++i) {
    const bool last = i + 1 >= test.time_s.size() || test.time_s[i + 1] >= end_s;
    const double until_s = last ? end_s : test.time_s[i + 1];
    add((until_s - from_s) / (end_s - begin_s), test.operating[i], mean);
    from_s = until_s;
  }
  return mean;
}

}  // namespace

std::vector<TestStep> test_steps(const ThermalTest& test, double longest_step_s) {
  std::vector<TestStep> steps;
  const double last_s = test.time_s.back();
  double begin_s = test.time_s.front(), changed_s = begin_s;
  std::size_t first = 0;
  while (begin_s < last_s - instant_slack_s) {
    const double length_s =
        std::clamp(growth_share * (begin_s - changed_s), shortest_share * longest_step_s, longest_step_s);
    double end_s = begin_s + length_s;
    if (end_s > last_s - instant_slack_s) end_s = last_s;
    for (std::size_t i = first + 1; i < test.time_s.size() && test.time_s[i] <= end_s + instant_slack_s; ++i) {
      if (!inputs_changed(test.operating[i], test.operating[first])) continue;
      end_s = changed_s = test.time_s[i];
      break;
    }
    steps.push_back({begin_s, end_s, mean_inputs(test, first, begin_s, end_s)});
    begin_s = end_s;
    while (first + 1 < test.time_s.size() && test.time_s[first + 1] <= begin_s + instant_slack_s) ++first;
  }
  return steps;
}

}  // namespace spindle_twin::correction
