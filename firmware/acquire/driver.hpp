#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/acquire/channel_filter.hpp"
#include "firmware/acquire/conversion.hpp"
#include "firmware/acquire/device_readings.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// What one step of a driver came to.
struct Step {
  enum class Is {
    fresh,    ///< the device is there; its readings are taken
    waiting,  ///< nobody is there, and nothing can be done about it: the next step follows without back-off
    lost,     ///< the device cannot be had: the next step begins anew after the back-off
  };
  Is is = Is::fresh;
  std::string reason;  ///< of `waiting` and `lost`, for the log
};

/// A device that is talked to, in a thread of its own: it may block and allocate.
class Driver {
 public:
  virtual ~Driver() = default;

  /// One poll, or what has come meanwhile; connects first where it must. Hands each value to `readings` with the time
  /// when it was measured, and counts there what was not taken. Comes back within 0.5 s, or within a timeout that its
  /// plan names. What it throws counts as a lost device.
  virtual Step step(DeviceReadings& readings) = 0;
};

/// What the keys of a channel say of the number that the device gives.
struct ChannelSource {
  double scale = 1.0;       ///< default of the channel's key `scale`
  bool is_counted = false;  ///< whole steps of 1, as of an integer register; else its steps are not known
  std::string place = {};   ///< of the device, for messages: "input register 6"
};

/// Where somebody waits for connections.
struct ListenPlace {
  std::string address;  ///< IPv4; 0.0.0.0: all of this computer
  int port = 0;         ///< 0: any free one
};

/// A device as the configuration has it: the keys of its [[device]] table that only its driver knows.
class DriverPlan {
 public:
  virtual ~DriverPlan() = default;

  /// Reads the keys of a sensor or signal that say where it stands in the device. The calls number the channels:
  /// 0, 1... Throws rom::InputError.
  virtual ChannelSource add_channel(const rom::TomlTable& table) = 0;

  virtual std::unique_ptr<Driver> make_driver(Clock& clock) const = 0;
  /// As the log names it, "192.168.1.7:502".
  virtual std::string where() const = 0;
  /// Where nodes connect to it; empty where it connects itself.
  virtual std::optional<ListenPlace> listens() const { return std::nullopt; }
  /// Whether steps are made each `poll_s`; else one after the other, and the driver waits itself.
  virtual bool polls() const { return true; }
};

/// One device with all its channels; made from the configuration.
struct DevicePlan {
  std::string name = "device";
  double poll_s = 1.0;        ///< clock time between steps; 0: none, the driver waits itself
  double delay_s = 0.0;       ///< clock time from the measurement until the device shows it
  double retry_s = 0.1;       ///< clock time until the first new attempt after a loss, doubled each time
  double retry_most_s = 5.0;  ///< at most
  std::shared_ptr<DriverPlan> driver;
  std::vector<Channel> channels;  ///< in the order of add_channel()
};

}  // namespace spindle_twin::firmware
