#pragma once

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// The [correction] table: law, options, guards and groups, into config.cycle and config.groups.
void read_correction(const rom::TomlTable& table, Config& config);

}  // namespace spindle_twin::firmware
