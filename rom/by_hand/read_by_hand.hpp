#pragma once

#include <string>

#include "rom/network.hpp"

namespace spindle_twin::rom {

/// Reads a network that a person wrote (rom/by_hand/README.md has the keys): nodes with capacities, conductances,
/// sources and outputs, from TOML. The result is as any other network, marked hand_written and without a certificate;
/// its description_hash is the file's SHA-256. Throws InputError with file, line and field: unknown or missing keys,
/// values out of range, names that do not exist, a node that nothing connects, two groups of nodes without a path
/// between them, no film that leads heat away.
Network read_by_hand(const std::string& path);
Network parse_by_hand(const std::string& text, const std::string& file);

/// True if the file can be read and has nodes: a hand-written network and not a spindle description.
bool is_by_hand(const std::string& path);

}  // namespace spindle_twin::rom
