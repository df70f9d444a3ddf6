#pragma once

#include <string>
#include <vector>

#include "firmware/serve/allow_list.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// The key `address`, an IPv4 address. Throws rom::InputError.
std::string read_ipv4(const rom::TomlTable& table, const std::string& otherwise);

/// The key `allow`, by default this machine only; not an empty list. Throws rom::InputError.
std::vector<AddressRange> read_allow(const rom::TomlTable& table);

/// A key of such addresses, which may be an empty list; `otherwise` where it is not there. Throws rom::InputError.
std::vector<AddressRange> read_allow_or(const rom::TomlTable& table, const char* key,
                                        const std::vector<AddressRange>& otherwise);

}  // namespace spindle_twin::firmware
