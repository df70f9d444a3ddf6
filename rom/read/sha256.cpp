#include "rom/read/sha256.hpp"

#include <sodium.h>

namespace spindle_twin::rom {

static_assert(sizeof(Sha256) == crypto_hash_sha256_BYTES);

Sha256 sha256(std::span<const std::uint8_t> bytes) {
  Sha256 digest;
  crypto_hash_sha256(digest.data(), bytes.data(), bytes.size());
  return digest;
}

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text(2 * bytes.size() + 1, '\0');  // sodium ends it with a zero
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

std::string sha256_hex(std::string_view text) {
  return hex(sha256(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size())));
}

}  // namespace spindle_twin::rom
