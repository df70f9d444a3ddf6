#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/acquire/channel_filter.hpp"
#include "firmware/acquire/conversion.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Where a value of a device goes in the DeviceFrame, and what becomes of it on the way.
struct Channel {
  enum class Kind { sensor, signal, displacement };
  Kind kind = Kind::sensor;
  std::size_t index = 0;  ///< key point, Signal or deformation output
  std::string name;       ///< for the log
  Conversion conversion;  ///< to K, rpm, a fraction, A, W, kg/s or m
  FilterPlan filter;
};

/// What one device has said so far. For the device's own thread.
class DeviceReadings {
 public:
  /// `number`: which of the daemon's devices, from 0.
  DeviceReadings(std::string device, std::size_t number, const std::vector<Channel>& channels, double delay_s);

  /// A number as it stands in the device, measured at time_ns (monotonic) less the device's delay: converted and
  /// filtered. One that is older than the channel's last by more than a second changes nothing; else what comes later
  /// counts as later.
  void take(std::size_t channel, double number, std::int64_t time_ns);
  /// An answer or frame that was not taken.
  void refuse() { ++state().refused; }
  /// An answer or frame that was taken.
  void accept() { ++state().accepted; }

  void set_connected(bool connected) { frame_.connected = state().connected = connected; }
  const DeviceFrame& frame() const { return frame_; }

 private:
  struct Line {
    Channel channel;
    ChannelFilter filter;
    std::int64_t last_ns = 0;
    WireFault fault = WireFault::none;
  };
  DeviceState& state() { return frame_.devices[number_]; }
  Reading& reading_of(const Channel& channel);
  void note(Line& line, WireFault fault, std::int64_t time_ns);

  std::string device_;
  std::size_t number_;
  std::vector<Line> lines_;
  std::int64_t delay_ns_;
  LogLimit changes_{6, 60.0};
  DeviceFrame frame_;
};

}  // namespace spindle_twin::firmware
