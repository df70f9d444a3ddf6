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

/// The text in front keeps a signature made for anything else from fitting here.
constexpr std::string_view purpose = "spindle-twin network file\n";
using Message = std::array<std::uint8_t, purpose.size() + header::size>;

Message signed_message(std::span<const std::uint8_t> file_header) {
  Message message;
  std::copy(file_header.begin(), file_header.end(), std::copy(purpose.begin(), purpose.end(), message.begin()));
  return message;
}

}  // namespace

std::vector<std::uint8_t> sign_bytes(std::vector<std::uint8_t> bytes, const PrivateKey& key) {
  const auto payload_size = header::get_little_endian<std::uint64_t>(bytes.data() + header::length_at);
  bytes.resize(header::size + payload_size);
  header::put_little_endian(rom_format_version_signed, bytes.data() + header::version_at);
  const Message message = signed_message(std::span(bytes).first(header::size));
  std::array<std::uint8_t, signature_block_size> block;
  std::copy(block_magic.begin(), block_magic.end(), block.begin());
  const PublicKey signer = public_key(key);
  std::copy(signer.begin(), signer.end(), block.begin() + key_at);
  crypto_sign_detached(block.data() + signature_at, nullptr, message.data(), message.size(), key.secret.data());
  bytes.insert(bytes.end(), block.begin(), block.end());
  return bytes;
}

std::optional<PublicKey> verified_signer(std::span<const std::uint8_t> file_header,
                                         std::span<const std::uint8_t> block) {
  if (block.size() != signature_block_size || !std::equal(block_magic.begin(), block_magic.end(), block.begin())) {
    return std::nullopt;
  }
  PublicKey signer;
  std::copy_n(block.begin() + key_at, signer.size(), signer.begin());
  const Message message = signed_message(file_header);
  if (crypto_sign_verify_detached(block.data() + signature_at, message.data(), message.size(), signer.data()) != 0) {
    return std::nullopt;
  }
  return signer;
}

void sign_file(const std::string& path, const PrivateKey& key) {
  const std::vector<std::uint8_t> bytes = read_whole_file(path, rom_largest_file_bytes);
  decode_rom_file(bytes, path);
  write_whole_file(path, sign_bytes(bytes, key));
}

}  // namespace spindle_twin::rom
