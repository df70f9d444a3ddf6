#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "firmware/cycle/plan.hpp"

namespace spindle_twin::bench {

/// The daemon's own defaults, `sensors` of them at a device and the signals from a PLC.
inline firmware::CyclePlan default_plan(std::size_t sensors, double cycle_s) {
  firmware::CyclePlan plan;
  plan.period_s = cycle_s;
  for (std::size_t s = 0; s < sensors; ++s) {
    plan.sensors[s].configured = true;
    plan.sensors[s].stale_after_s = std::max(plan.sensors[s].stale_after_s, 1.5 * cycle_s);
  }
  for (std::size_t s = 0; s < static_cast<std::size_t>(firmware::Signal::current); ++s) {
    plan.signals[s].source = firmware::SignalSource::plc;
    plan.signals[s].stale_after_s = std::max(3.0, 1.5 * cycle_s);
  }
  plan.estimator.emplace().period_s = std::max(10.0, cycle_s);
  return plan;
}

/// The daemon's clock at time_s of a run.
inline std::int64_t clock_ns(double time_s) {
  return 1'000'000'000LL + static_cast<std::int64_t>(std::llround(1e9 * time_s));
}

}  // namespace spindle_twin::bench
