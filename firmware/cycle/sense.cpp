#include "firmware/cycle/sense.hpp"

#include <algorithm>

namespace spindle_twin::firmware {
namespace {

Sensed sensed_at(const Reading& reading, std::int64_t now_ns, double clock_rate) {
  Sensed sensed;
  if (reading.time_ns == 0) return sensed;
  sensed.value = reading.value;
  sensed.time_ns = reading.time_ns;
  // A reading that came in after the cycle woke up is of age 0.
  sensed.age_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now_ns - reading.time_ns)) * clock_rate;
  return sensed;
}

/// Whether who told a signal has not been heard for longer than the plan allows.
bool is_silent(const CyclePlan& plan, std::int64_t alive_ns, std::int64_t now_ns) {
  const double silence_s = 1e-9 * static_cast<double>(now_ns - alive_ns);
  return plan.plc_timeout_s > 0.0 && alive_ns != 0 && silence_s > plan.plc_timeout_s;
}

}  // namespace

void sense(const CyclePlan& plan, const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
           SensedInputs& sensed) {
  for (std::size_t k = 0; k < sensed.sensors.size(); ++k) {
    sensed.sensors[k] = sensed_at(frame.sensors[k], now_ns, plan.clock_rate);
  }
  for (std::size_t d = 0; d < sensed.displacements.size(); ++d) {
    sensed.displacements[d] = sensed_at(frame.displacements[d], now_ns, plan.clock_rate);
  }
  for (std::size_t s = 0; s < signal_count; ++s) {
    switch (plan.signals[s].source) {
      case SignalSource::none:
        break;
      case SignalSource::constant:
        sensed.signals[s] = {plan.signals[s].value, 0.0, now_ns};
        break;
      case SignalSource::device:
        sensed.signals[s] = sensed_at(frame.signals[s], now_ns, plan.clock_rate);
        break;
      case SignalSource::plc:
        sensed.signals[s] = sensed_at(command.signals[s], now_ns, plan.clock_rate);
        sensed.signals[s].silent = is_silent(plan, command.alive_ns[s], now_ns);
        break;
    }
  }
  sensed.device_connected = frame.connected;
  sensed.devices = frame.devices;
}

}  // namespace spindle_twin::firmware
