#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rom/network.hpp"

/// The payload of a .rom file, without header and checks of physics; used by rom_file.cpp only.
namespace spindle_twin::rom {

/// What is written, and the oldest that is read. 2 brought coolant circuits, 3 certificates per output and the
/// hand_written mark, 4 physical laws, 5 measured heats, 6 limits of the errors; a file of an older version that has
/// what its version did not know is refused.
inline constexpr std::uint32_t payload_schema_version = 6;
inline constexpr std::uint32_t payload_schema_version_limits = 6;
inline constexpr std::uint32_t payload_schema_version_measured = 5;
inline constexpr std::uint32_t payload_schema_version_laws = 4;
inline constexpr std::uint32_t payload_schema_version_outputs = 3;
inline constexpr std::uint32_t payload_schema_version_circuits = 2;
inline constexpr std::uint32_t payload_schema_version_oldest = 1;

/// Room for any spindle; they keep a forged file from asking for memory and time.
inline constexpr std::size_t most_nodes = 2000;
inline constexpr std::size_t most_items = 10'000;  ///< of any other list

/// The bytes of message spindle_twin.rom.Network. Throws std::invalid_argument if lists that belong together differ in
/// length.
std::vector<std::uint8_t> encode_payload(const Network& network);

/// Throws InputError for a malformed message, an unknown schema version, sizes that disagree, more nodes or items than
/// the above. Sizes are checked before anything is allocated for them: no single allocation exceeds the payload's
/// length or most_items structures, whichever is larger.
struct DecodedPayload {
  Network network;
  std::uint32_t schema_version = 0;
};
DecodedPayload decode_payload(std::span<const std::uint8_t> payload, const std::string& file);

}  // namespace spindle_twin::rom
