#pragma once

#include <cstdint>
#include <span>

namespace spindle_twin::firmware {

struct RequestCount {
  std::uint32_t answered = 0;  ///< by libmodbus, with registers or an exception
  std::uint32_t refused = 0;   ///< with an exception before libmodbus saw them
  bool closed = false;         ///< what follows is no Modbus/TCP
};

/// Takes the bytes of one connection through the server's path of a request: gate, libmodbus, orders and signals.
/// Throws std::logic_error where the gate's verdict depends on how much has come already, where a request that the gate
/// lets through writes outside the command block, and where an answer is not one to its request.
RequestCount checked_requests(std::span<const std::uint8_t> bytes);

}  // namespace spindle_twin::firmware
