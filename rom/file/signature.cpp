#include "rom/file/signature.hpp"

#include <sodium.h>

#include <algorithm>
#include <string_view>

#include "rom/file/file_header.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"

namespace spindle_twin::rom {
namespace {

constexpr std::array<std::uint8_t, 8> block_magic = {'S', 'P', 'I', 'N', 'S', 'I', 'G', '\n'};
constexpr std::size_t key_at = block_magic.size();
constexpr std::size_t signature_at = key_at + crypto_sign_PUBLICKEYBYTES;
static_assert(signature_at + crypto_sign_BYTES == signature_block_size);

constexpr std::string_view network_purpose = "spindle-twin network file\n";

std::vector<std::uint8_t> with_purpose(std::string_view purpose, std::span<const std::uint8_t> message) {
  std::vector<std::uint8_t> whole(purpose.begin(), purpose.end());
  whole.insert(whole.end(), message.begin(), message.end());
  return whole;
}

}  // namespace

std::vector<std::uint8_t> signature_block(std::string_view purpose, std::span<const std::uint8_t> message,
                                          const PrivateKey& key) {
  const std::vector<std::uint8_t> whole = with_purpose(purpose, message);
  std::vector<std::uint8_t> block(signature_block_size);
  std::copy(block_magic.begin(), block_magic.end(), block.begin());
  const PublicKey signer = public_key(key);
  std::copy(signer.begin(), signer.end(), block.begin() + key_at);
  crypto_sign_detached(block.data() + signature_at, nullptr, whole.data(), whole.size(), key.secret.data());
  return block;
}

std::optional<PublicKey> signer_of(std::string_view purpose, std::span<const std::uint8_t> message,
                                   std::span<const std::uint8_t> block) {
  if (block.size() != signature_block_size || !std::equal(block_magic.begin(), block_magic.end(), block.begin())) {
    return std::nullopt;
  }
  PublicKey signer;
  std::copy_n(block.begin() + key_at, signer.size(), signer.begin());
  const std::vector<std::uint8_t> whole = with_purpose(purpose, message);
  if (crypto_sign_verify_detached(block.data() + signature_at, whole.data(), whole.size(), signer.data()) != 0) {
    return std::nullopt;
  }
  return signer;
}

std::vector<std::uint8_t> sign_bytes(std::vector<std::uint8_t> bytes, const PrivateKey& key) {
  const auto payload_size = header::get_little_endian<std::uint64_t>(bytes.data() + header::length_at);
  bytes.resize(header::size + payload_size);
  header::put_little_endian(rom_format_version_signed, bytes.data() + header::version_at);
  const std::vector<std::uint8_t> block = signature_block(network_purpose, std::span(bytes).first(header::size), key);
  bytes.insert(bytes.end(), block.begin(), block.end());
  return bytes;
}

std::optional<PublicKey> verified_signer(std::span<const std::uint8_t> file_header,
                                         std::span<const std::uint8_t> block) {
  return signer_of(network_purpose, file_header, block);
}

void sign_file(const std::string& path, const PrivateKey& key) {
  const std::vector<std::uint8_t> bytes = read_whole_file(path, rom_largest_file_bytes);
  decode_rom_file(bytes, path);
  write_whole_file(path, sign_bytes(bytes, key));
}

}  // namespace spindle_twin::rom
