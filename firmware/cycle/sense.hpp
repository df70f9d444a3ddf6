#pragma once

#include "firmware/cycle/plan.hpp"

namespace spindle_twin::firmware {

/// A reading as the cycle sees it.
struct Sensed {
  double value = not_a_value;
  double age_s = std::numeric_limits<double>::infinity();  ///< model time; infinite: never read
  std::int64_t time_ns = 0;                                ///< of the reading, monotonic; tells a new one from a repeat
  bool silent = false;                                     ///< who told it is not heard any more (plc_timeout_s)
};

struct SensedInputs {
  std::array<Sensed, slots::key_points> sensors;
  std::array<double, slots::key_points> raw_K{};  ///< readings before the sensor tare
  std::array<Sensed, signal_count> signals;
  std::array<Sensed, slots::deformations> displacements;
  bool device_connected = false;
  std::array<DeviceState, slots::devices> devices;
};

/// Picks each value from where the plan says and works out its age, clock_rate · (now − time of reading).
/// Runs in the cycle.
void sense(const CyclePlan& plan, const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
           SensedInputs& sensed);

}  // namespace spindle_twin::firmware
