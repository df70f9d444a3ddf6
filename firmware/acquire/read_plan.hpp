#pragma once

#include <cstdint>
#include <vector>

#include "firmware/acquire/register_source.hpp"

namespace spindle_twin::firmware {

/// One Modbus request and the channels that it serves, by their number.
struct ReadRequest {
  RegisterTable table = RegisterTable::input;
  std::uint16_t address = 0;
  std::uint16_t count = 0;
  std::vector<std::size_t> channels;
};

/// Neighbouring registers of one table are read together, at most 125 at a time. Registers that no channel names are
/// never asked for: a device may refuse them.
std::vector<ReadRequest> plan_requests(const std::vector<RegisterSource>& channels);

}  // namespace spindle_twin::firmware
