#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "firmware/acquire/read_plan.hpp"
#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// Waiting time after so many failures in a row: 0.1 s after the first (`failures` 0), doubled each time, at most 5 s.
double back_off_s(int failures);

/// Polls a data-acquisition device as Modbus/TCP client (libmodbus) in the thread that calls run().
/// A lost connection is made again with back-off; until then the last readings stay and grow old. An answer that the
/// device refuses (exception) keeps the connection: only its channels grow old.
class ModbusDevice {
 public:
  ModbusDevice(DevicePlan plan, Clock& clock, Latest<DeviceFrame>& frames);
  ~ModbusDevice();
  ModbusDevice(const ModbusDevice&) = delete;
  ModbusDevice& operator=(const ModbusDevice&) = delete;

  /// Until `stop` is set; comes back within timeout_s + 0.1 s then.
  void run(const std::atomic<bool>& stop);

 private:
  bool connect();
  Reading& reading_of(const Channel& channel);
  bool poll();
  void sleep_until(std::int64_t time_ns, const std::atomic<bool>& stop);

  struct Context;
  DevicePlan plan_;
  Clock& clock_;
  Latest<DeviceFrame>& frames_;
  std::vector<ReadRequest> requests_;
  DeviceFrame frame_;
  std::unique_ptr<Context> context_;
};

}  // namespace spindle_twin::firmware
