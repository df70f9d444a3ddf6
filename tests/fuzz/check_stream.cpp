#include "tests/fuzz/check_stream.hpp"

#include <algorithm>
#include <stdexcept>

#include "firmware/acquire/stream_decoder.hpp"

namespace spindle_twin::firmware {
namespace {

/// The sum stands for all that the messages say: a difference would show.
struct Outcome {
  StreamCount count;
  std::uint32_t sum = 0;
};

std::uint32_t sum_of(const spindle_twin_stream_Readings& message) {
  std::uint32_t sum = message.time_ms + message.readings_count;
  for (pb_size_t i = 0; i < message.readings_count; ++i) {
    sum = 31 * sum + message.readings[i].channel + message.readings[i].age_ms;
  }
  return 31 * sum + message.burst.values_count;
}

Outcome decode(std::span<const std::uint8_t> bytes, std::size_t piece) {
  StreamDecoder decoder;
  Outcome outcome;
  spindle_twin_stream_Readings message = spindle_twin_stream_Readings_init_zero;
  while (!bytes.empty()) {
    const auto room = decoder.room();
    if (room.empty()) throw std::logic_error("no room for more");
    const std::size_t count = std::min({piece, room.size(), bytes.size()});
    std::copy_n(bytes.begin(), count, room.begin());
    decoder.received(count);
    bytes = bytes.subspan(count);
    while (decoder.next(message)) {
      ++outcome.count.taken;
      outcome.sum = 31 * outcome.sum + sum_of(message);
    }
  }
  while (decoder.has_part()) {
    decoder.give_up();
    while (decoder.next(message)) ++outcome.count.taken;
  }
  outcome.count.refused = decoder.refused();
  return outcome;
}

}  // namespace

StreamCount checked_stream(std::span<const std::uint8_t> bytes) {
  const Outcome whole = decode(bytes, bytes.size());
  for (const std::size_t piece : {std::size_t{1}, std::size_t{13}, std::size_t{1000}}) {
    const Outcome pieces = decode(bytes, piece);
    if (pieces.count.taken != whole.count.taken || pieces.count.refused != whole.count.refused ||
        pieces.sum != whole.sum) {
      throw std::logic_error("pieces make a difference");
    }
  }
  constexpr std::size_t around = StreamDecoder::header_bytes + StreamDecoder::crc_bytes;
  if (whole.count.taken * (around + 1) > bytes.size()) throw std::logic_error("more frames than bytes for them");
  return whole.count;
}

}  // namespace spindle_twin::firmware
