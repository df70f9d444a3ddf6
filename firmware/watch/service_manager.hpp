#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "firmware/watch/pulse.hpp"

namespace spindle_twin::firmware {

/// Tells the service manager how the daemon is (sd_notify(3)), by the pulse of each spindle:
///   READY=1      after the first cycle with a prediction, or with the fault that nothing can be predicted from, of all
///   WATCHDOG=1   when each has made a cycle since the last one: a cycle that hangs is not covered up by a thread that
///                lives, nor by another spindle
///   STATUS=      what `systemctl status` shows
/// Where there is no service manager nothing happens.
class ServiceManager {
 public:
  using Notify = std::function<void(const std::string&)>;

  /// cycle_s: clock time from cycle to cycle, of the slowest. watchdog_s: what the service manager asks for, 0:
  /// nothing; it is asked for three cycles instead where that is longer. The pulses must outlive this.
  ServiceManager(const std::vector<const Pulse*>& pulses, double cycle_s, double watchdog_s, Notify notify);
  /// With the service manager of this process.
  ServiceManager(const std::vector<const Pulse*>& pulses, double cycle_s);

  /// Looks at each pulse once; each look_s() or more often.
  void look();
  double look_s() const { return look_s_; }

  /// Until `stop` is set; in a thread of its own.
  void run(const std::atomic<bool>& stop);

 private:
  struct Watched {
    const Pulse* pulse;
    std::uint64_t seen = 0;
    bool beats = false;  ///< since the last WATCHDOG=1
  };
  bool all_beat();

  std::vector<Watched> spindles_;
  Notify notify_;
  double cycle_s_;
  double watchdog_s_;
  double look_s_;
  bool ready_ = false;
  bool told_ = false;  // that it waits
};

}  // namespace spindle_twin::firmware
