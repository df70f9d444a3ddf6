#include "rom/file/rom_file.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <span>

#include "rom/file/payload.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

constexpr std::array<std::uint8_t, 8> magic = {'S', 'P', 'I', 'N', 'R', 'O', 'M', '\n'};
constexpr std::size_t version_at = magic.size();
constexpr std::size_t length_at = version_at + sizeof(std::uint32_t);
constexpr std::size_t hash_at = length_at + sizeof(std::uint64_t);
constexpr std::size_t header_size = hash_at + crypto_hash_sha256_BYTES;
static_assert(header_size == 52);

template <class Integer>
void put_little_endian(Integer value, std::uint8_t* target) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i) target[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

template <class Integer>
Integer get_little_endian(const std::uint8_t* source) {
  Integer value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i) value |= static_cast<Integer>(source[i]) << (8 * i);
  return value;
}

using Hash = std::array<std::uint8_t, crypto_hash_sha256_BYTES>;

Hash sha256(std::span<const std::uint8_t> bytes) {
  Hash hash;
  crypto_hash_sha256(hash.data(), bytes.data(), bytes.size());
  return hash;
}

}  // namespace

std::vector<std::uint8_t> encode_network(const Network& network) {
  const std::vector<std::uint8_t> payload = encode_payload(network);
  const Hash hash = sha256(payload);
  std::vector<std::uint8_t> bytes(header_size + payload.size());
  std::copy(magic.begin(), magic.end(), bytes.begin());
  put_little_endian(rom_format_version, bytes.data() + version_at);
  put_little_endian(static_cast<std::uint64_t>(payload.size()), bytes.data() + length_at);
  std::copy(hash.begin(), hash.end(), bytes.begin() + hash_at);
  std::copy(payload.begin(), payload.end(), bytes.begin() + header_size);
  return bytes;
}

Network decode_network(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  const SourceLine where{file, 0};
  const std::size_t shared = std::min(bytes.size(), magic.size());
  if (bytes.empty() || !std::equal(magic.begin(), magic.begin() + static_cast<std::ptrdiff_t>(shared), bytes.begin())) {
    throw InputError(where, "", "not a .rom file");
  }
  if (bytes.size() < header_size) {
    throw InputError(where, "header", "truncated: " + std::to_string(bytes.size()) + " of 52 bytes");
  }
  const auto version = get_little_endian<std::uint32_t>(bytes.data() + version_at);
  if (version != rom_format_version) {
    throw InputError(where, "format version",
                     std::to_string(version) + " is unknown; this program reads " + std::to_string(rom_format_version));
  }
  const auto length = get_little_endian<std::uint64_t>(bytes.data() + length_at);
  const std::span<const std::uint8_t> payload = std::span(bytes).subspan(header_size);
  if (payload.size() != length) {
    throw InputError(where, "payload",
                     (payload.size() < length ? "truncated: " : "too long: ") + std::to_string(payload.size()) +
                         " bytes, the header says " + std::to_string(length));
  }
  const Hash hash = sha256(payload);
  if (!std::equal(hash.begin(), hash.end(), bytes.begin() + hash_at)) {
    throw InputError(where, "payload", "damaged: its SHA-256 is not the header's");
  }
  Network network = decode_payload(payload, file);
  check_network(network, file);
  return network;
}

void write_network(const Network& network, const std::string& path) {
  check_network(network, path);
  write_whole_file(path, encode_network(network));
}

Network read_network(const std::string& path) {
  return decode_network(read_whole_file(path, rom_largest_file_bytes), path);
}

}  // namespace spindle_twin::rom
