#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/acquire/driver.hpp"
#include "firmware/cycle/hand_over.hpp"

namespace spindle_twin::firmware {

/// Waiting time after so many losses in a row: retry_s after the first (`losses` 0), doubled each time, at most
/// retry_most_s.
double back_off_s(const DevicePlan& plan, int losses);

/// One device in the thread that calls run(): steps of its driver at their period, back-off after a loss, a line in the
/// log per change. Until a lost device is back its last readings stay and grow old.
class DeviceThread {
 public:
  /// `number`: which of the daemon's devices, from 0. `clock` and `frames` must outlive this.
  DeviceThread(const DevicePlan& plan, std::size_t number, Clock& clock, Latest<DeviceFrame>& frames);

  /// Until `stop` is set; comes back 0.1 s after the step then.
  void run(const std::atomic<bool>& stop);

 private:
  Step step();
  void note(const Step& step);
  void sleep_until(std::int64_t time_ns, const std::atomic<bool>& stop);

  DevicePlan plan_;
  Clock& clock_;
  Latest<DeviceFrame>& frames_;
  std::unique_ptr<Driver> driver_;
  DeviceReadings readings_;
  std::optional<bool> said_connected_;  ///< as the log has it
  std::string said_reason_;
  LogLimit changes_{6, 60.0};
};

}  // namespace spindle_twin::firmware
