#pragma once

#include <optional>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// The table [compensation], after [output] and [cycle] were read. Throws rom::InputError.
void read_compensation(const std::optional<rom::TomlTable>& table, Config& config);

/// What it needs of the network and of the limits of its outputs, which stand in `plan` already. Throws rom::InputError
/// for an output that the network does not have.
void bind_compensation(const Config& config, const rom::Network& network, CyclePlan& plan);

}  // namespace spindle_twin::firmware
