#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/watch/log_limit.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// Says in the log what happens: one line per change of the state, of a fault, of a sensor, and per result of an order,
/// a few per kind and minute. In the thread that calls run(); the cycle thread only leaves its snapshots. What comes
/// and goes within run()'s slice of 20 ms is not seen.
class EventLog {
 public:
  explicit EventLog(const rom::Network& network);

  Latest<Snapshot>& tap() { return tap_; }

  /// Until `stop` is set.
  void run(const std::atomic<bool>& stop);

  /// Compares with the snapshot before. now_ns: monotonic.
  void note(const Snapshot& snapshot, std::int64_t now_ns);

  /// A line where the clock on the wall, which says unix_s now, was set by a second or more since the call before.
  void note_clock(double unix_s, std::int64_t now_ns);

 private:
  void note_state(const Snapshot& now, std::int64_t now_ns);
  void note_faults(const Snapshot& now, std::int64_t now_ns);
  void note_sensors(const Snapshot& now, std::int64_t now_ns);
  void note_orders(const Snapshot& now, std::int64_t now_ns);
  void note_overruns(const Snapshot& now, std::int64_t now_ns);
  void note_trial(const Snapshot& now, std::int64_t now_ns);

  std::vector<std::string> key_points_;
  Latest<Snapshot> tap_;
  Snapshot before_;
  bool first_ = true;
  std::optional<double> clock_offset_s_;  ///< of the clock on the wall to the monotonic one
  std::array<OrderRecord, order_records> told_{};
  LogLimit states_{10, 60.0}, faults_{10, 60.0}, sensors_{16, 60.0}, orders_{20, 60.0}, overruns_{1, 60.0},
      clock_{6, 60.0}, trials_{20, 60.0};
};

}  // namespace spindle_twin::firmware
