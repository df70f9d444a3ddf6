#pragma once

#include <bitset>
#include <vector>

#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/register_map.hpp"

namespace spindle_twin::firmware {

/// The registers that PLCs write may be written: the command block.
WriteRange writable_registers();

/// A command block with nothing written.
void clear_commands(RegisterImage& image);

/// Whether a request writes registers that may bring orders.
bool may_order(WriteRange written);
/// More orders cannot come with one request.
inline constexpr std::size_t most_orders = 6;

/// Which signals.
using SignalSet = std::bitset<signal_count>;

/// Takes over what a request wrote to `image` at now_ns into `told`: only what it wrote counts as read now. Which of
/// these it wrote.
SignalSet take_signals(WriteRange written, std::int64_t now_ns, const RegisterImage& image, PlcSignals& told);

/// How the switches stand by the last order, as their registers have it.
struct Switched {
  std::uint16_t correction = not_present_code;
  std::uint16_t compensation = not_present_code;
};

/// The orders that a request wrote to `image`, at most most_orders; their registers are set back to 0. A switch is one
/// only where it is not as `switched` says, so that who writes all registers each second orders once.
std::vector<Order> take_orders(WriteRange written, const Switched& switched, RegisterImage& image);

}  // namespace spindle_twin::firmware
