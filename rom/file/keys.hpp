#pragma once

#include <array>
#include <cstdint>
#include <string>

/// Ed25519 keys (libsodium) in small TOML files: NAME.key holds the seed and is for its owner only, NAME.pub the public
/// key. Nothing here may run in the cycle.
namespace spindle_twin::rom {

using PublicKey = std::array<std::uint8_t, 32>;

struct PrivateKey {
  std::array<std::uint8_t, 64> secret{};  ///< libsodium's form: seed, then public key
  PrivateKey() = default;
  PrivateKey(const PrivateKey&) = default;
  PrivateKey& operator=(const PrivateKey&) = default;
  ~PrivateKey();  ///< wipes it
};

PrivateKey make_private_key();
PublicKey public_key(const PrivateKey& key);

/// 64 lower-case hex digits.
std::string to_hex(const PublicKey& key);

/// Writes `path`, mode 0600, whole or not at all; throws InputError if it exists, since a lost key cannot be replaced.
void write_private_key(const PrivateKey& key, const std::string& path);
/// Writes `path` like any other output.
void write_public_key(const PublicKey& key, const std::string& path);

/// Throws InputError for anything but a private key, and for a file that others than its owner may read.
PrivateKey read_private_key(const std::string& path);
/// Throws InputError for anything but a public key.
PublicKey read_public_key(const std::string& path);

/// True and `key` if `text` is 64 hex digits.
bool parse_public_key(const std::string& text, PublicKey& key);

}  // namespace spindle_twin::rom
