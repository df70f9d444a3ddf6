#pragma once

#include <optional>
#include <vector>

#include "firmware/acquire/driver.hpp"
#include "firmware/config/listeners.hpp"

namespace spindle_twin::firmware {

/// A channel as the configuration has it: of which device, and what becomes of its number.
struct ConfiguredChannel {
  std::size_t device = 0;  ///< index of Config::devices
  std::size_t number = 0;  ///< among the device's channels
  Conversion conversion;   ///< to SI
  FilterPlan filter;
  double step = 0.0;       ///< of the value, in the channel's unit; 0: not known
  std::string place = {};  ///< of the device: "input register 6"
};

/// [[device]] tables, or the one [device] of before; those that nodes connect to are noted in `listeners`. Throws
/// rom::InputError.
std::vector<DevicePlan> read_devices(const rom::TomlTable& root, double clock_rate, Listeners& listeners);

/// Where a sensor, signal or probe comes from: its keys device, conversion, scale, offset, filter and those of the
/// device's driver. `unit` leads to SI. Adds a channel to the device. Throws rom::InputError.
ConfiguredChannel read_channel(const rom::TomlTable& table, Unit unit, double clock_rate,
                               std::vector<DevicePlan>& devices);

}  // namespace spindle_twin::firmware
