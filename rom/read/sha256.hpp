#pragma once

#include <string>
#include <string_view>

namespace spindle_twin::rom {

/// SHA-256 of the bytes, 64 lower-case hex digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace spindle_twin::rom
