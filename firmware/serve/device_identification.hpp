#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace spindle_twin::firmware {

/// Answer to a whole FC43/14 request: vendor, product, version (basic), address and product name (regular).
/// An object that does not exist is exception 2, an unknown category exception 3, as the Modbus specification says.
std::vector<std::uint8_t> identify_device(std::span<const std::uint8_t> request);

}  // namespace spindle_twin::firmware
