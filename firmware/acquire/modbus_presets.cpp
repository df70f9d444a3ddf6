#include "firmware/acquire/modbus_presets.hpp"

#include <algorithm>
#include <array>

namespace spindle_twin::firmware {
namespace {

// Moxa ioLogik E1260 (Modbus/TCP), user's manual of the E1200 series, "E1260 Modbus Mapping": 31537 to 31542 (0x0600),
// function 4, one word each, unit 0.1 degC as set in the module.
// iSMA CONTROLLI SFAR-S-6TI (RTU, behind a gateway), its "Module Registers": 30053 to 30058 (decimal address 52),
// function 4, degC times 10.
const std::array presets{
    ModbusPreset{"moxa_e1260", {RegisterTable::input, 1536, RegisterType::int16}, 0.1, 6},
    ModbusPreset{"isma_sfar_s_6ti", {RegisterTable::input, 52, RegisterType::int16}, 0.1, 6},
};

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const ModbusPreset& preset : presets) names.emplace_back(preset.name);
  return names;
}

const ModbusPreset& preset_of(const std::string& name) {
  return *std::find_if(presets.begin(), presets.end(), [&](const ModbusPreset& preset) { return name == preset.name; });
}

}  // namespace spindle_twin::firmware
