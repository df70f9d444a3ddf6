#include "firmware/acquire/stream_decoder.hpp"

#include <pb_decode.h>

#include <algorithm>

namespace spindle_twin::firmware {
namespace {

constexpr std::uint8_t magic_0 = 'S';
constexpr std::uint8_t magic_1 = 'T';
constexpr std::uint8_t version = 1;
constexpr std::size_t version_at = 2;
constexpr std::size_t reserved_at = 3;
constexpr std::size_t length_at = 4;
constexpr std::size_t sequence_at = 6;

constexpr std::array<std::uint32_t, 256> crc_table = [] {
  constexpr std::uint32_t polynomial = 0xEDB88320U;  // reflected
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? polynomial : 0U);
    table[byte] = crc;
  }
  return table;
}();

std::uint32_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint32_t number = 0;
  for (const std::uint8_t byte : bytes) number = (number << 8U) | byte;
  return number;
}

std::size_t payload_bytes(std::span<const std::uint8_t> frame) { return big_endian(frame.subspan(length_at, 2)); }

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) crc = (crc >> 8U) ^ crc_table[(crc ^ byte) & 0xFFU];
  return ~crc;
}

std::span<std::uint8_t> StreamDecoder::room() {
  if (begin_ > 0) {
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_), bytes_.begin() + static_cast<std::ptrdiff_t>(end_),
              bytes_.begin());
    end_ -= begin_;
    begin_ = 0;
  }
  return std::span(bytes_).subspan(end_);
}

/// What the bytes from begin_ on are, which start with the first byte of a frame.
StreamDecoder::Frame StreamDecoder::look() const {
  const std::span<const std::uint8_t> bytes = held();
  const auto differs = [&](std::size_t at, std::uint8_t wanted) { return bytes.size() > at && bytes[at] != wanted; };
  if (bytes.empty()) return Frame::none;
  if (differs(1, magic_1)) return Frame::none;
  if (differs(version_at, version) || differs(reserved_at, 0)) return Frame::refused;
  if (bytes.size() < header_bytes) return Frame::not_whole;
  const std::size_t payload = payload_bytes(bytes);
  if (payload == 0 || payload > longest_payload) return Frame::refused;
  const std::size_t before_crc = header_bytes + payload;
  if (bytes.size() < before_crc + crc_bytes) return Frame::not_whole;
  const bool undamaged = crc32(bytes.first(before_crc)) == big_endian(bytes.subspan(before_crc, crc_bytes));
  return undamaged ? Frame::whole : Frame::refused;
}

/// Bytes before the next possible start belong to no frame; false: there is no start.
bool StreamDecoder::skip_to_start() {
  const std::span<const std::uint8_t> bytes = held();
  std::size_t skipped = 0;
  while (skipped < bytes.size() &&
         (bytes[skipped] != magic_0 || (skipped + 1 < bytes.size() && bytes[skipped + 1] != magic_1))) {
    ++skipped;
  }
  if (skipped > 0 && !between_frames_) ++refused_;
  between_frames_ = between_frames_ || skipped > 0;
  begin_ += skipped;
  return has_part();
}

void StreamDecoder::refuse() {
  ++refused_;
  between_frames_ = true;
  ++begin_;
}

/// A frame that is whole: its message, unless it is not new or says nothing that can be read.
bool StreamDecoder::take(spindle_twin_stream_Readings& message) {
  const std::span<const std::uint8_t> bytes = held();
  const std::size_t payload = payload_bytes(bytes);
  const std::uint32_t sequence = big_endian(bytes.subspan(sequence_at, 4));
  begin_ += header_bytes + payload + crc_bytes;
  between_frames_ = false;
  const bool is_new = !sequence_ || static_cast<std::int32_t>(sequence - *sequence_) > 0;
  pb_istream_t stream = pb_istream_from_buffer(bytes.data() + header_bytes, payload);
  message = spindle_twin_stream_Readings_init_zero;
  if (!is_new || !pb_decode(&stream, spindle_twin_stream_Readings_fields, &message)) {
    ++refused_;
    return false;
  }
  sequence_ = sequence;
  return true;
}

bool StreamDecoder::next(spindle_twin_stream_Readings& message) {
  while (skip_to_start()) {
    switch (look()) {
      case Frame::whole:
        if (take(message)) return true;
        break;
      case Frame::refused:
        refuse();
        break;
      default:
        return false;
    }
  }
  return false;
}

void StreamDecoder::give_up() {
  if (has_part()) refuse();
}

}  // namespace spindle_twin::firmware
