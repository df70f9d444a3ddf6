#pragma once

#include <optional>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// [exchange]: the slot, how long a new network is tried and watched, by how much it may do worse. Throws
/// rom::InputError; also for a slot that is no folder, and without trusted keys.
void read_exchange(const std::optional<rom::TomlTable>& table, Config& config);

}  // namespace spindle_twin::firmware
