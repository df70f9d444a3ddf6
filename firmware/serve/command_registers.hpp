#pragma once

#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/register_map.hpp"

namespace spindle_twin::firmware {

/// The registers that PLCs write may be written: the command block.
WriteRange writable_registers();

/// A command block with nothing written.
void clear_commands(RegisterImage& image);

/// Takes over what a request wrote to `image` at now_ns into `command`: only what it wrote counts as read now.
/// An order (tare, measured length) is taken and its register set back to 0.
void take_commands(WriteRange written, std::int64_t now_ns, RegisterImage& image, PlcCommand& command);

}  // namespace spindle_twin::firmware
