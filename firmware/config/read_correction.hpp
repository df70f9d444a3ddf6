#pragma once

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// The [correction] table: law, options, priors, guards and groups, into config.cycle and config.groups. Without the
/// table the estimator corrects where there are sensors.
void read_correction(const std::optional<rom::TomlTable>& table, Config& config);

}  // namespace spindle_twin::firmware
