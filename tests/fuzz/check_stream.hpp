#pragma once

#include <cstdint>
#include <span>

namespace spindle_twin::firmware {

struct StreamCount {
  std::uint32_t taken = 0;
  std::uint32_t refused = 0;
};

/// Takes the bytes of one connection through the stream's decoder, at once and in pieces. Throws std::logic_error where
/// the pieces make a difference, where the decoder has no room for more, or where it takes more than was sent.
StreamCount checked_stream(std::span<const std::uint8_t> bytes);

}  // namespace spindle_twin::firmware
