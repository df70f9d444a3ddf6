#pragma once

#include <optional>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

inline constexpr rom::Range resolution_range_K = rom::between(0.0, 10.0);

/// The [health] table into config.cycle; without one the defaults.
void read_health(const std::optional<rom::TomlTable>& table, Config& config);

}  // namespace spindle_twin::firmware
