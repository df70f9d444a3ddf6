#pragma once

#include <array>
#include <cstddef>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// The newest readings from the threads of all devices to the cycle: a triple buffer for each, nobody waits.
class DeviceInbox {
 public:
  /// Where device `number` puts its frames, each of which has all its readings.
  Latest<DeviceFrame>& of(std::size_t number) { return latest_[number]; }

  /// Brings `all` up to date: each value comes from the one device that gives it. Runs in the cycle.
  void read(DeviceFrame& all) {
    for (std::size_t number = 0; number < latest_.size(); ++number) {
      if (!latest_[number].read(one_)) continue;
      take(one_.sensors, all.sensors);
      take(one_.signals, all.signals);
      take(one_.displacements, all.displacements);
      all.devices[number] = one_.devices[number];
    }
    bool any = false;
    bool missing = false;
    for (const DeviceState& device : all.devices) {
      any = any || device.used;
      missing = missing || (device.used && !device.connected);
    }
    all.connected = any && !missing;
  }

 private:
  template <std::size_t room>
  static void take(const std::array<Reading, room>& from, std::array<Reading, room>& to) {
    for (std::size_t i = 0; i < room; ++i) {
      if (from[i].time_ns != 0) to[i] = from[i];
    }
  }

  std::array<Latest<DeviceFrame>, slots::devices> latest_;
  DeviceFrame one_;
};

}  // namespace spindle_twin::firmware
