#include "firmware/acquire/drivers.hpp"

#include <algorithm>
#include <array>

#include "firmware/acquire/modbus_device.hpp"
#include "firmware/acquire/stream_device.hpp"

namespace spindle_twin::firmware {
namespace {

struct Kind {
  const char* name;
  std::shared_ptr<DriverPlan> (*read)(const rom::TomlTable& device);
};

/// A new driver is a line here, its header and its source.
const std::array kinds{
    Kind{"modbus", read_modbus_plan},
    Kind{"stream", read_stream_plan},
};

}  // namespace

std::vector<std::string> driver_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds) names.emplace_back(kind.name);
  return names;
}

std::shared_ptr<DriverPlan> read_driver(const rom::TomlTable& device) {
  const std::string name = device.choice_or("driver", "modbus", driver_names());
  return std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) { return name == kind.name; })->read(device);
}

}  // namespace spindle_twin::firmware
