#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rom/network.hpp"

/// The payload of a .rom file, without header and checks of physics; used by rom_file.cpp only.
namespace spindle_twin::rom {

/// A network without coolant circuits is written as version 1, byte for byte as before circuits came. One with circuits
/// is version 2, so that a program that knows none refuses it instead of taking its segments for plain films.
inline constexpr std::uint32_t payload_schema_version = 1;
inline constexpr std::uint32_t payload_schema_version_circuits = 2;

/// The bytes of message spindle_twin.rom.Network. Throws std::invalid_argument if lists that belong together differ in
/// length.
std::vector<std::uint8_t> encode_payload(const Network& network);

/// Throws InputError for a malformed message, an unknown schema version, sizes that disagree. Allocates no more than a
/// small multiple of the payload's size.
Network decode_payload(std::span<const std::uint8_t> payload, const std::string& file);

}  // namespace spindle_twin::rom
