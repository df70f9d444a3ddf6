#pragma once

#include <string>
#include <vector>

#include "firmware/serve/allow_list.hpp"

namespace spindle_twin::firmware {

/// What the Modbus server needs; made once from the configuration.
struct ServePlan {
  std::string address = "127.0.0.1";  ///< IPv4 to listen on
  int port = 502;                     ///< 0 takes a free one (tests)
  std::vector<AddressRange> allow;    ///< clients that are answered
  std::vector<AddressRange> write;    ///< of these, whose writes are taken
  int connections = 32;               ///< at most at once
  int connections_per_host = 16;      ///< of these, from one address
  double idle_s = 300.0;              ///< a connection without a request for so long is closed
  double frame_deadline_s = 1.0;      ///< from a request's first byte to its last

  bool operator==(const ServePlan&) const = default;
};

}  // namespace spindle_twin::firmware
