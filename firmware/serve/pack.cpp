#include "firmware/serve/pack.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace spindle_twin::firmware {
namespace {

struct CountRange {
  double min;
  double max;
  std::uint32_t not_present;
};

CountRange range_of(RegisterType type) {
  switch (type) {
    case RegisterType::uint16:
      return {0.0, 65534.0, 0xFFFFU};
    case RegisterType::int16:
      return {-32767.0, 32767.0, 0x8000U};
    case RegisterType::offset16:
      return {-32767.0, 32767.0, 0x0000U};
    case RegisterType::uint32:
      return {0.0, 4294967294.0, 0xFFFFFFFFU};
    case RegisterType::int32:
      return {-2147483647.0, 2147483647.0, 0x80000000U};
    default:
      return {-static_cast<double>(std::numeric_limits<float>::max()),
              static_cast<double>(std::numeric_limits<float>::max()), 0x7FC00000U};
  }
}

bool is_float(RegisterType type) { return type == RegisterType::float32 || type == RegisterType::float32_cdab; }

void put_bits(RegisterImage& image, const RegisterEntry& entry, int slot, std::uint32_t bits) {
  const std::size_t at = std::size_t{entry.address} + static_cast<std::size_t>(slot * words_of(entry.type));
  const auto low = static_cast<std::uint16_t>(bits & 0xFFFFU);
  const auto high = static_cast<std::uint16_t>(bits >> 16U);
  if (words_of(entry.type) == 1) {
    image[at] = low;
  } else if (entry.type == RegisterType::float32_cdab) {
    image[at] = low;
    image[at + 1] = high;
  } else {
    image[at] = high;
    image[at + 1] = low;
  }
}

std::uint32_t get_bits(const RegisterImage& image, const RegisterEntry& entry, int slot) {
  const std::size_t at = std::size_t{entry.address} + static_cast<std::size_t>(slot * words_of(entry.type));
  if (words_of(entry.type) == 1) return image[at];
  const std::uint32_t first = image[at];
  const std::uint32_t second = image[at + 1];
  return entry.type == RegisterType::float32_cdab ? (second << 16U) | first : (first << 16U) | second;
}

}  // namespace

bool put(RegisterImage& image, Register which, double value, int slot) {
  const RegisterEntry& entry = entry_of(which);
  if (std::isnan(value)) {
    put_not_present(image, which, slot);
    return true;
  }
  const CountRange range = range_of(entry.type);
  double count = value / entry.resolution;
  if (!is_float(entry.type)) count = std::round(count);
  const double clipped = std::clamp(count, range.min, range.max);
  std::uint32_t bits = 0;
  switch (entry.type) {
    case RegisterType::uint16:
    case RegisterType::uint32:
      bits = static_cast<std::uint32_t>(clipped);
      break;
    case RegisterType::int16:
    case RegisterType::int32:
      bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(clipped));
      break;
    case RegisterType::offset16:
      bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(clipped) + 32768);
      break;
    default:
      bits = std::bit_cast<std::uint32_t>(static_cast<float>(clipped));
  }
  put_bits(image, entry, slot, bits);
  return clipped == count;
}

void put_not_present(RegisterImage& image, Register which, int slot) {
  const RegisterEntry& entry = entry_of(which);
  put_bits(image, entry, slot, range_of(entry.type).not_present);
}

double get(const RegisterImage& image, Register which, int slot) {
  const RegisterEntry& entry = entry_of(which);
  const std::uint32_t bits = get_bits(image, entry, slot);
  if (is_float(entry.type)) return static_cast<double>(std::bit_cast<float>(bits)) * entry.resolution;
  if (bits == range_of(entry.type).not_present) return std::numeric_limits<double>::quiet_NaN();
  double count = 0.0;
  switch (entry.type) {
    case RegisterType::int16:
      count = static_cast<std::int16_t>(bits);
      break;
    case RegisterType::int32:
      count = static_cast<std::int32_t>(bits);
      break;
    case RegisterType::offset16:
      count = static_cast<double>(bits) - 32768.0;
      break;
    default:
      count = bits;
  }
  return count * entry.resolution;
}

}  // namespace spindle_twin::firmware
