#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/acquire/modbus_answer.hpp"
#include "firmware/acquire/read_plan.hpp"
#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Waiting time after so many failures in a row: 0.1 s after the first (`failures` 0), doubled each time, at most 5 s.
double back_off_s(int failures);

/// Polls a data-acquisition device as Modbus/TCP client (libmodbus) in the thread that calls run().
/// An answer counts only if transaction, protocol id, unit, function and lengths are those of the question; another one
/// ends the connection. A lost connection is made again with back-off; until then the last readings stay and grow old.
/// An answer that the device refuses (exception) keeps the connection: only its channels grow old.
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
  bool ask(const ReadQuestion& question, std::span<std::uint8_t> frame, CheckedAnswer& answer);
  bool poll();
  void note_refused(std::size_t request, std::uint8_t exception);
  void note_connected(bool connected);
  void sleep_until(std::int64_t time_ns, const std::atomic<bool>& stop);

  struct Context;
  DevicePlan plan_;
  Clock& clock_;
  Latest<DeviceFrame>& frames_;
  std::vector<ReadRequest> requests_;
  std::vector<std::uint8_t> refused_;  ///< exception that each request got last; 0: none
  std::uint16_t transaction_ = 0;
  std::string reason_;                  ///< why the device does not answer
  std::optional<bool> said_connected_;  ///< as the log has it
  std::string said_reason_;
  LogLimit changes_{6, 60.0};
  DeviceFrame frame_;
  std::unique_ptr<Context> context_;
};

}  // namespace spindle_twin::firmware
