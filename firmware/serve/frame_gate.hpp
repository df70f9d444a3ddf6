#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

namespace spindle_twin::firmware {

inline constexpr std::size_t mbap_bytes = 7;       ///< transaction, protocol, length, unit
inline constexpr std::size_t longest_frame = 260;  ///< MBAP + 253 bytes of PDU

/// What becomes of the bytes at the front of a connection.
enum class Verdict {
  wait,       ///< the frame is not whole: `bytes` must be there before it is worth looking again
  close,      ///< not Modbus/TCP; where the next frame begins is unknown
  hand_over,  ///< a whole, well-formed request of `bytes` for libmodbus
  identify,   ///< a whole device identification request (FC43/14), which libmodbus does not know
  refuse,     ///< a whole frame to be answered with `exception`
};

/// A run of registers, such as those that a request writes.
struct WriteRange {
  int address = 0;
  int count = 0;  ///< 0: none
};

/// Unit identifiers that are answered, by their number.
using Units = std::bitset<256>;
/// Of a daemon with one spindle: 1, and what clients send that have no setting for it, 0 and 255.
Units units_of_one_spindle();

struct Gate {
  Verdict verdict = Verdict::wait;
  std::size_t bytes = 0;
  std::uint8_t exception = 0;  ///< Modbus exception code
  WriteRange write;
};

/// Judges the frame at the front of `received` (what is there so far) before libmodbus sees any of it, because its
/// server reads a frame by blocking and believes the header: a frame that stays half, a wrong length or a function it
/// does not know would hold up every client. In this order: protocol id 0, length 2 to 254, frame whole, one of `units`
/// (else exception 11), function 3, 4, 6, 16, 22, 23 or 43/14 (else 1), the length and quantity that the function
/// allows (else 3), writes inside `writable` and input registers outside `holding_only` (else 2).
Gate judge_frame(std::span<const std::uint8_t> received, WriteRange writable, WriteRange holding_only = {},
                 const Units& units = units_of_one_spindle());
/// The unit identifier of a frame that judge_frame() has found whole.
inline std::uint8_t unit_of(std::span<const std::uint8_t> frame) { return frame[mbap_bytes - 1]; }

}  // namespace spindle_twin::firmware
