#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/acquire/register_source.hpp"

namespace spindle_twin::firmware {

/// A request to read registers, as it goes to one unit.
struct ReadQuestion {
  std::uint16_t transaction = 0;
  std::uint8_t unit = 1;
  RegisterTable table = RegisterTable::input;
  std::uint16_t address = 0;
  std::uint16_t count = 1;  ///< 1 to 125
};

inline constexpr std::size_t question_bytes = 12;
inline constexpr std::size_t longest_answer = 260;

/// The frame as it is sent.
std::array<std::uint8_t, question_bytes> encode(const ReadQuestion& question);

enum class Answer {
  not_whole,  ///< so far nothing contradicts
  wrong,      ///< not an answer to this question: another transaction, protocol, unit, function, length or byte count
  refused,    ///< whole, an exception
  values,     ///< whole, `bytes` in all
};

struct CheckedAnswer {
  Answer is = Answer::not_whole;
  std::size_t bytes = 0;
  std::uint8_t exception = 0;
};

/// Judges what has been received since the question was sent. Written here because libmodbus 3.1.6 checks neither unit
/// nor length, and the protocol id only in part: a device or gateway that mixes up answers would be believed.
CheckedAnswer check_answer(const ReadQuestion& question, std::span<const std::uint8_t> received);

/// Register i of an answer with values.
std::uint16_t word_of(std::span<const std::uint8_t> answer, std::size_t i);

}  // namespace spindle_twin::firmware
