#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::firmware {

/// A twin and a machine whose sensors are noisy, have offsets and may be tampered with; one cycle a second.
struct Watched {
  Watched(const rom::Network& network, const CyclePlan& plan, double heat)
      : cycle(network, plan, runtime), machine(network, heat) {}

  void until(int seconds) {
    for (; n < seconds; ++n) {
      DeviceFrame frame = machine.frame(at_s(n));
      for (std::size_t k = 0; k < 3; ++k) frame.sensors[k].value += offset_K[k] + noise_K * normal(random);
      if (tamper) tamper(n, frame);
      const long calls = rom::tests::heap_calls();
      last = cycle.step(frame, command, at_s(n), 0);
      heap_calls += rom::tests::heap_calls() - calls;
      machine.advance(1.0);
    }
  }

  /// The PLC orders, and the machine goes on for so long.
  void give(SensorOrder order, int seconds) {
    command.sensor_order = order;
    ++command.sensor_orders;
    until(n + seconds);
  }

  Cycle cycle;
  Machine machine;
  PlcCommand command;
  Snapshot last;
  std::function<void(int, DeviceFrame&)> tamper;
  std::array<double, 3> offset_K{};
  double noise_K = 0.03;
  std::mt19937_64 random{8};
  std::normal_distribution<double> normal{0.0, 1.0};
  int n = 0;
  long heap_calls = 0;
};

/// Sensors that nobody has tared.
inline CyclePlan untared() {
  CyclePlan plan = estimated();
  plan.estimator->offset_deviation_K = 0.2;
  for (SensorPlan& sensor : plan.sensors) sensor.offset_deviation_K = 0.2;
  return plan;
}

/// Of a machine that stands still; a tare is offered after a quarter of an hour.
inline CyclePlan at_rest(CyclePlan plan) {
  plan.signals[0].value = 0.0;
  plan.signals[1].value = 0.0;
  plan.tare.rest_s = 900.0;
  return plan;
}

}  // namespace spindle_twin::firmware
