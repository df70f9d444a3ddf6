#include "rom/file/keys.hpp"

#include <sodium.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <span>
#include <stdexcept>

#include "rom/file/whole_file.hpp"
#include "rom/read/sha256.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::rom {
namespace {

using Seed = std::array<std::uint8_t, crypto_sign_SEEDBYTES>;
static_assert(std::tuple_size_v<PublicKey> == crypto_sign_PUBLICKEYBYTES);
static_assert(sizeof(PrivateKey::secret) == crypto_sign_SECRETKEYBYTES);

constexpr const char* private_field = "ed25519_private_seed";
constexpr const char* public_field = "ed25519_public_key";

void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium has no source of random numbers");
}

template <std::size_t size>
bool unhex(const std::string& text, std::array<std::uint8_t, size>& bytes) {
  std::size_t length = 0;
  return text.size() == 2 * size &&
         sodium_hex2bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &length, nullptr) == 0 &&
         length == size;
}

template <std::size_t size>
std::array<std::uint8_t, size> read_hex(const std::string& path, const char* field) {
  const TomlTable file = TomlTable::read(path);
  std::array<std::uint8_t, size> bytes{};
  if (!unhex(file.string(field), bytes)) file.fail(field, "must be " + std::to_string(2 * size) + " hex digits");
  file.finish();
  return bytes;
}

PrivateKey from_seed(Seed& seed) {
  PrivateKey key;
  PublicKey unused;
  crypto_sign_seed_keypair(unused.data(), key.secret.data(), seed.data());
  sodium_memzero(seed.data(), seed.size());
  return key;
}

}  // namespace

PrivateKey::~PrivateKey() { sodium_memzero(secret.data(), secret.size()); }

PrivateKey make_private_key() {
  start_sodium();
  Seed seed;
  randombytes_buf(seed.data(), seed.size());
  return from_seed(seed);
}

PublicKey public_key(const PrivateKey& key) {
  PublicKey result;
  crypto_sign_ed25519_sk_to_pk(result.data(), key.secret.data());
  return result;
}

std::string to_hex(const PublicKey& key) { return hex(key); }

bool parse_public_key(const std::string& text, PublicKey& key) { return unhex(text, key); }

void write_private_key(const PrivateKey& key, const std::string& path) {
  Seed seed;
  crypto_sign_ed25519_sk_to_seed(seed.data(), key.secret.data());
  std::string text =
      "# Private key for signing spindle-twin network files. Whoever has it can sign; keep it to yourself.\n";
  text.append(private_field).append(" = \"").append(hex(seed)).append("\"\n");
  sodium_memzero(seed.data(), seed.size());
  write_private_file(path, text);
  sodium_memzero(text.data(), text.size());
}

void write_public_key(const PublicKey& key, const std::string& path) {
  std::string text = "# Public key for checking signatures of spindle-twin network files; for everyone.\n";
  text.append(public_field).append(" = \"").append(hex(key)).append("\"\n");
  write_whole_file(path, text);
}

PrivateKey read_private_key(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0) {
    char mode[8];
    std::snprintf(mode, sizeof mode, "%04o", static_cast<unsigned>(status.st_mode & 07777));
    throw InputError({path, 0}, "permissions",
                     std::string("a private key must be its owner's alone: chmod 600, it has ") + mode);
  }
  start_sodium();
  Seed seed = read_hex<crypto_sign_SEEDBYTES>(path, private_field);
  return from_seed(seed);
}

PublicKey read_public_key(const std::string& path) { return read_hex<crypto_sign_PUBLICKEYBYTES>(path, public_field); }

}  // namespace spindle_twin::rom
