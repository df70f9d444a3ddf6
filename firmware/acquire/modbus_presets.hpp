#pragma once

#include <string>
#include <vector>

#include "firmware/acquire/register_source.hpp"

namespace spindle_twin::firmware {

/// A module whose inputs stand one behind the other, so that a channel needs only its number.
struct ModbusPreset {
  const char* name = "";
  RegisterSource first;  ///< of channel 0
  double scale = 1.0;    ///< number * scale is in degC
  int channels = 0;
};

/// What `preset` may be in a [[device]] table.
std::vector<std::string> preset_names();

/// One of preset_names().
const ModbusPreset& preset_of(const std::string& name);

}  // namespace spindle_twin::firmware
