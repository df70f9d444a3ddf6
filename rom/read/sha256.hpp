#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace spindle_twin::rom {

using Sha256 = std::array<std::uint8_t, 32>;

Sha256 sha256(std::span<const std::uint8_t> bytes);

/// Two lower-case digits per byte.
std::string hex(std::span<const std::uint8_t> bytes);

/// SHA-256 of the text, 64 lower-case hex digits.
std::string sha256_hex(std::string_view text);

}  // namespace spindle_twin::rom
