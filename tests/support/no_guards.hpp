#pragma once

#include "correction/paper/paper_options.hpp"

namespace spindle_twin::tests {

/// Guards so wide that none acts: for reproducing the law as it was published.
inline correction::PaperGuards no_guards() {
  correction::PaperGuards guards;
  guards.reading_uncertainty_K = 0.0;
  guards.minimum_rise_K = 0.0;
  guards.step_minimum = guards.heat_minimum = 0.0;
  guards.resistance_minimum = 0.001;
  guards.step_maximum = guards.heat_maximum = guards.resistance_maximum = guards.resistance_step = 1e6;
  guards.minimum_sensors = 1;
  guards.settle_s = 0.0;
  guards.standstill_rpm = 0.0;
  guards.deadband = false;
  return guards;
}

}  // namespace spindle_twin::tests
