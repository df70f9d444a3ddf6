#include "rom/file/rom_file.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>

#include "rom/file/file_header.hpp"
#include "rom/file/payload.hpp"
#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::rom {
namespace {

/// The payload; what may follow it is the signature block. Throws InputError for anything that does not add up.
std::span<const std::uint8_t> payload_of(const std::vector<std::uint8_t>& bytes, std::uint32_t version,
                                         const SourceLine& where) {
  const auto length = header::get_little_endian<std::uint64_t>(bytes.data() + header::length_at);
  const std::size_t behind = version == rom_format_version_signed ? signature_block_size : 0;
  const std::size_t have = bytes.size() - header::size;
  if (have < behind || have - behind != length) {
    const bool cut = have < behind || have - behind < length;
    throw InputError(where, "payload",
                     (cut ? "truncated: " : "too long: ") + std::to_string(have) + " bytes, the header says " +
                         std::to_string(length) + (behind > 0 ? " and a signature of 104" : ""));
  }
  return std::span(bytes).subspan(header::size, length);
}

/// What a person who gives a description in a network's place has left out; empty where it is no description.
std::string way_to_one(const std::string& file) {
  return file.ends_with(".toml")
             ? "; `spindle-twin build` makes one of a spindle's description, `spindle-twin assemble` "
               "of a network written by hand"
             : "";
}

}  // namespace

std::vector<std::uint8_t> encode_network(const Network& network) {
  const std::vector<std::uint8_t> payload = encode_payload(network);
  const Sha256 hash = sha256(payload);
  std::vector<std::uint8_t> bytes(header::size + payload.size());
  std::copy(header::magic.begin(), header::magic.end(), bytes.begin());
  header::put_little_endian(rom_format_version, bytes.data() + header::version_at);
  header::put_little_endian(static_cast<std::uint64_t>(payload.size()), bytes.data() + header::length_at);
  std::copy(hash.begin(), hash.end(), bytes.begin() + header::hash_at);
  std::copy(payload.begin(), payload.end(), bytes.begin() + header::size);
  return bytes;
}

RomFile decode_rom_file(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  const SourceLine where{file, 0};
  const std::size_t shared = std::min(bytes.size(), header::magic.size());
  if (bytes.empty() ||
      !std::equal(header::magic.begin(), header::magic.begin() + static_cast<std::ptrdiff_t>(shared), bytes.begin())) {
    throw InputError(where, "", "not a .rom file" + way_to_one(file));
  }
  if (bytes.size() < header::size) {
    throw InputError(where, "header", "truncated: " + std::to_string(bytes.size()) + " of 52 bytes");
  }
  const auto version = header::get_little_endian<std::uint32_t>(bytes.data() + header::version_at);
  if (version != rom_format_version && version != rom_format_version_signed) {
    throw InputError(where, "format version", std::to_string(version) + " is unknown; this program reads 1 and 2");
  }
  const std::span<const std::uint8_t> payload = payload_of(bytes, version, where);
  const Sha256 hash = sha256(payload);
  if (!std::equal(hash.begin(), hash.end(), bytes.begin() + header::hash_at)) {
    throw InputError(where, "payload", "damaged: its SHA-256 is not the header's");
  }
  RomFile result;
  if (version == rom_format_version_signed) {
    result.signed_by =
        verified_signer(std::span(bytes).first(header::size), std::span(bytes).subspan(header::size + payload.size()));
    if (!result.signed_by) throw InputError(where, "signature", "does not fit the file, or is damaged");
  }
  result.sha256 = hex(hash);
  DecodedPayload decoded = decode_payload(payload, file);
  result.network = std::move(decoded.network);
  result.schema_version = decoded.schema_version;
  check_network(result.network, file);
  return result;
}

Network decode_network(const std::vector<std::uint8_t>& bytes, const std::string& file) {
  return decode_rom_file(bytes, file).network;
}

void write_network(const Network& network, const std::string& path) {
  check_network(network, path);
  const std::vector<std::uint8_t> bytes = encode_network(network);
  if (bytes.size() + signature_block_size > rom_largest_file_bytes) {
    throw InputError({path, 0}, "",
                     "would have " + std::to_string(bytes.size()) + " bytes, and no file above " +
                         std::to_string(rom_largest_file_bytes) + " is read; fewer nodes make it smaller");
  }
  write_whole_file(path, bytes);
}

RomFile read_rom_file(const std::string& path) {
  return decode_rom_file(read_whole_file(path, rom_largest_file_bytes), path);
}

bool is_rom_file(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, header::magic.size()> begin{};
  file.read(begin.data(), begin.size());
  return file.gcount() == begin.size() && std::equal(begin.begin(), begin.end(), header::magic.begin());
}

Network read_network(const std::string& path) { return read_rom_file(path).network; }

}  // namespace spindle_twin::rom
