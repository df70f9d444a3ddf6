#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "rom/read/sha256.hpp"

/// Where things stand in a .rom file; used by rom_file.cpp and signature.cpp only.
namespace spindle_twin::rom::header {

inline constexpr std::array<std::uint8_t, 8> magic = {'S', 'P', 'I', 'N', 'R', 'O', 'M', '\n'};
inline constexpr std::size_t version_at = magic.size();
inline constexpr std::size_t length_at = version_at + sizeof(std::uint32_t);
inline constexpr std::size_t hash_at = length_at + sizeof(std::uint64_t);
inline constexpr std::size_t size = hash_at + sizeof(Sha256);
static_assert(size == 52);

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

}  // namespace spindle_twin::rom::header
