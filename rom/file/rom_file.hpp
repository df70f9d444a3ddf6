#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rom/file/keys.hpp"
#include "rom/network.hpp"

/// The .rom file: a fixed header, then the payload of rom/file/rom.proto (nanopb).
///
///   bytes  0- 7  magic "SPINROM\n"
///          8-11  format version, little endian: 1 unsigned, 2 with a signature block (rom/file/signature.hpp)
///         12-19  payload length in bytes, little endian
///         20-51  SHA-256 of the payload
///         52-    payload, then the signature block if there is one
///
/// Any single damaged bit and any missing or added byte is refused. Nothing here may run in the cycle.
namespace spindle_twin::rom {

inline constexpr std::uint32_t rom_format_version = 1;
inline constexpr std::uint32_t rom_format_version_signed = 2;
inline constexpr std::uint64_t rom_largest_file_bytes = std::uint64_t{1} << 26;

/// A network and what its file says of itself.
struct RomFile {
  Network network;
  std::uint32_t schema_version = 0;    ///< of the payload
  std::string sha256;                  ///< of the payload, hex
  std::optional<PublicKey> signed_by;  ///< whose signature fits; whether to trust that key is the reader's question
};

/// Checks the network, writes a temporary file beside `path`, syncs it and renames it over `path`: the file is there
/// whole or not at all. Throws InputError naming file and field.
void write_network(const Network& network, const std::string& path);

/// Reads and checks. Throws InputError naming file and field: not a .rom file, another format version, truncated or too
/// long, damaged (hash), a signature that does not fit, malformed payload, an unknown schema version, sizes that
/// disagree, and all that check_network refuses. No single allocation exceeds 64 MiB.
RomFile read_rom_file(const std::string& path);
Network read_network(const std::string& path);

/// Whether a file begins as a network file does; false where it cannot be read.
bool is_rom_file(const std::string& path);

/// The file's bytes, unchecked.
std::vector<std::uint8_t> encode_network(const Network& network);

/// The inverse, with all checks of read_rom_file; `file` is only for messages.
RomFile decode_rom_file(const std::vector<std::uint8_t>& bytes, const std::string& file);
Network decode_network(const std::vector<std::uint8_t>& bytes, const std::string& file);

/// The physics that every network keeps, to 1e-9 of the matrix' largest entry (1e-6 for weights that sum to 1): shapes,
/// finite values, C symmetric positive definite, K₀ symmetric positive semidefinite with rows that sum to zero, columns
/// of Fⱼ that sum to zero where no environment is exchanged with, columns of B and rows of temperature outputs that sum
/// to 1, indices in range, physical laws of the right kind with numbers in range, nominal values and areas >= 0,
/// temperatures above 0 K, errors of the certificate finite, >= 0 and one per output or none. Throws InputError; `file`
/// is only for messages.
void check_network(const Network& network, const std::string& file);

}  // namespace spindle_twin::rom
