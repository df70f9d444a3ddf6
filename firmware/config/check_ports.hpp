#pragma once

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// No port may be listened on twice: by [serve], [http] and the devices that nodes connect to. An address of 0.0.0.0
/// takes the port of all addresses; port 0 (tests) is a free one. Throws rom::InputError at the second.
void check_ports(const rom::TomlTable& root, const Config& config);

}  // namespace spindle_twin::firmware
