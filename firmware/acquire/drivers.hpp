#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware/acquire/driver.hpp"

namespace spindle_twin::firmware {

/// What `driver` may be in a [[device]] table.
std::vector<std::string> driver_names();

/// The plan that the table's `driver` (default "modbus") makes of its own keys. Throws rom::InputError.
std::shared_ptr<DriverPlan> read_driver(const rom::TomlTable& device);

}  // namespace spindle_twin::firmware
