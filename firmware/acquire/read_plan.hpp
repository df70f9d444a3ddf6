#pragma once

#include <string>
#include <vector>

#include "firmware/acquire/register_source.hpp"

namespace spindle_twin::firmware {

/// Where a value of the device goes in the DeviceFrame.
struct Channel {
  enum class Kind { sensor, signal, displacement };
  Kind kind = Kind::sensor;
  std::size_t index = 0;  ///< key point, Signal or deformation output
  RegisterSource source;  ///< scale and offset lead to K, rpm, a fraction or m
};

struct DevicePlan {
  std::string address = "127.0.0.1";  ///< IPv4
  int port = 502;
  int unit = 1;
  double poll_s = 1.0;     ///< clock time between polls
  double timeout_s = 0.5;  ///< for an answer
  std::vector<Channel> channels;
};

/// One Modbus request and the channels that it serves.
struct ReadRequest {
  RegisterTable table = RegisterTable::input;
  std::uint16_t address = 0;
  std::uint16_t count = 0;
  std::vector<std::size_t> channels;
};

/// Neighbouring registers of one table are read together, at most 125 at a time. Registers that no channel names are
/// never asked for: a device may refuse them.
std::vector<ReadRequest> plan_requests(const std::vector<Channel>& channels);

}  // namespace spindle_twin::firmware
