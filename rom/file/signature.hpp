#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rom/file/keys.hpp"

/// Signatures of files: a block of 104 bytes at the end. Of a .rom file it stands behind the payload, announced by
/// format version 2; of a calibration behind the message, announced by the first line (correction/calibration).
///
///   bytes  0-  7  magic "SPINSIG\n"
///          8- 39  Ed25519 public key of the signer
///         40-103  Ed25519 signature of a purpose + what is signed
///
/// Of a .rom file that is "spindle-twin network file\n" + its header, which holds the payload's length and SHA-256, so
/// that the signature covers every byte in front of the block; and its format version, so that a signature cannot be
/// cut off without the file being refused.
namespace spindle_twin::rom {

inline constexpr std::size_t signature_block_size = 104;

/// A block for `message`. The purpose keeps a signature that was made for one kind of file from fitting another.
std::vector<std::uint8_t> signature_block(std::string_view purpose, std::span<const std::uint8_t> message,
                                          const PrivateKey& key);

/// The key that made the block's signature for this purpose and message; empty if it does not fit.
std::optional<PublicKey> signer_of(std::string_view purpose, std::span<const std::uint8_t> message,
                                   std::span<const std::uint8_t> block);

/// The file's bytes with a signature in place of the one they have, if any. `bytes` must be a whole .rom file.
std::vector<std::uint8_t> sign_bytes(std::vector<std::uint8_t> bytes, const PrivateKey& key);

/// signer_of a .rom file with this header.
std::optional<PublicKey> verified_signer(std::span<const std::uint8_t> file_header,
                                         std::span<const std::uint8_t> block);

/// Reads, checks all that read_network checks, signs, and replaces the file. Throws InputError.
void sign_file(const std::string& path, const PrivateKey& key);

}  // namespace spindle_twin::rom
