#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace spindle_twin::rom {

/// Takes bytes through the loader of network files: "" if they are a network, else the reason of the refusal. Throws
/// std::logic_error for a refusal without file and reason, and for a network that changes when it is written and read.
std::string checked_network_file(const std::vector<std::uint8_t>& bytes);

}  // namespace spindle_twin::rom
