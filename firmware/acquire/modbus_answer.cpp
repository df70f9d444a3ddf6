#include "firmware/acquire/modbus_answer.hpp"

namespace spindle_twin::firmware {
namespace {

// Offsets in a frame: transaction 0, protocol 2, length 4, unit 6, function 7, byte count or exception 8, words 9.
constexpr std::size_t unit_at = 6;
constexpr std::size_t function_at = 7;
constexpr std::size_t count_at = 8;
constexpr std::size_t words_at = 9;
constexpr std::uint8_t exception_bit = 0x80;

std::uint8_t function_of(RegisterTable table) { return table == RegisterTable::input ? 4 : 3; }
std::uint8_t high(std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8U); }
std::uint8_t low(std::uint16_t word) { return static_cast<std::uint8_t>(word & 0xFFU); }

}  // namespace

std::array<std::uint8_t, question_bytes> encode(const ReadQuestion& question) {
  return {high(question.transaction),
          low(question.transaction),
          0,
          0,
          0,
          6,
          question.unit,
          function_of(question.table),
          high(question.address),
          low(question.address),
          high(question.count),
          low(question.count)};
}

CheckedAnswer check_answer(const ReadQuestion& question, std::span<const std::uint8_t> received) {
  const std::size_t data_bytes = std::size_t{2} * question.count;
  const auto is = [&](std::size_t at, std::size_t wanted) { return received.size() <= at || received[at] == wanted; };
  const bool header_fits = is(0, high(question.transaction)) && is(1, low(question.transaction)) && is(2, 0) &&
                           is(3, 0) && is(4, 0) && is(unit_at, question.unit);
  if (!header_fits) return {Answer::wrong, 0, 0};
  if (received.size() <= function_at) return {};
  const std::uint8_t function = function_of(question.table);
  if (received[function_at] == (function | exception_bit)) {
    if (received[5] != 3 || received.size() > words_at) return {Answer::wrong, 0, 0};
    if (received.size() < words_at) return {};
    return {Answer::refused, words_at, received[count_at]};
  }
  const std::size_t bytes = words_at + data_bytes;
  const bool body_fits = received[function_at] == function && received[5] == 3 + data_bytes &&
                         is(count_at, data_bytes) && received.size() <= bytes;
  if (!body_fits) return {Answer::wrong, 0, 0};
  return received.size() == bytes ? CheckedAnswer{Answer::values, bytes, 0} : CheckedAnswer{};
}

std::uint16_t word_of(std::span<const std::uint8_t> answer, std::size_t i) {
  return static_cast<std::uint16_t>((answer[words_at + 2 * i] << 8U) | answer[words_at + 2 * i + 1]);
}

}  // namespace spindle_twin::firmware
