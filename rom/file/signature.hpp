#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rom/file/keys.hpp"

/// The optional signature of a .rom file: a block of 104 bytes behind the payload, announced by format version 2.
///
///   bytes  0-  7  magic "SPINSIG\n"
///          8- 39  Ed25519 public key of the signer
///         40-103  Ed25519 signature of "spindle-twin network file\n" + the file's header
///
/// The header holds the payload's length and SHA-256, so the signature covers every byte in front of the block; and its
/// format version, so that a signature cannot be cut off without the file being refused.
namespace spindle_twin::rom {

inline constexpr std::size_t signature_block_size = 104;

/// The file's bytes with a signature in place of the one they have, if any. `bytes` must be a whole .rom file.
std::vector<std::uint8_t> sign_bytes(std::vector<std::uint8_t> bytes, const PrivateKey& key);

/// The key that made the block's signature of this header; empty if it does not fit.
std::optional<PublicKey> verified_signer(std::span<const std::uint8_t> file_header,
                                         std::span<const std::uint8_t> block);

/// Reads, checks all that read_network checks, signs, and replaces the file. Throws InputError.
void sign_file(const std::string& path, const PrivateKey& key);

}  // namespace spindle_twin::rom
