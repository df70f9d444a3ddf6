#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/acquire/stream.pb.h"

namespace spindle_twin::firmware {

/// CRC-32 of zlib and Ethernet; 0xCBF43926 for "123456789".
std::uint32_t crc32(std::span<const std::uint8_t> bytes);

/// Finds the messages in the bytes of one connection (stream.proto says how they are framed), with room for two frames
/// and no heap. What cannot be a whole, undamaged and new frame is refused: once for each place where a frame begins,
/// and once for bytes that belong to none. It goes on at the next place where a frame may begin.
class StreamDecoder {
 public:
  static constexpr std::size_t header_bytes = 10;
  static constexpr std::size_t crc_bytes = 4;
  static constexpr std::size_t longest_payload = 2048;
  static constexpr std::size_t longest_frame = header_bytes + longest_payload + crc_bytes;

  /// Where the next bytes go; never empty once next() is false.
  std::span<std::uint8_t> room();
  /// So many bytes were put into room().
  void received(std::size_t bytes) { end_ += bytes; }

  /// The next message; false: more bytes are needed.
  bool next(spindle_twin_stream_Readings& message);

  /// Bytes are waiting for the rest of their frame.
  bool has_part() const { return end_ > begin_; }
  /// The frame that has begun will not become whole: it is refused, what follows its first byte is looked at anew.
  void give_up();

  std::uint32_t refused() const { return refused_; }

 private:
  enum class Frame { none, not_whole, refused, whole };
  Frame look() const;
  std::span<const std::uint8_t> held() const { return std::span(bytes_).subspan(begin_, end_ - begin_); }
  bool skip_to_start();
  void refuse();
  bool take(spindle_twin_stream_Readings& message);

  std::array<std::uint8_t, 2 * longest_frame> bytes_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint32_t refused_ = 0;
  bool between_frames_ = false;  ///< behind what was refused, until a frame is whole again
  std::optional<std::uint32_t> sequence_;
};

}  // namespace spindle_twin::firmware
