#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "firmware/acquire/device_thread.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/device_inbox.hpp"
#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/keep/event_log.hpp"
#include "firmware/keep/history_writer.hpp"
#include "firmware/keep/keeper.hpp"
#include "firmware/keep/order_keeper.hpp"
#include "firmware/run/prepare.hpp"
#include "firmware/run/slot_watch.hpp"
#include "firmware/serve/spindle_registers.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/pulse.hpp"

namespace spindle_twin::firmware {

/// One spindle at work: its cycle, its devices, and what keeps its orders, state, history and events, each in a thread
/// of its own. It shares nothing with another spindle but the clock, the log and the ports that show it.
class SpindleRun {
 public:
  /// Removes what a writer that was killed has left beside the spindle's files, whose locks the caller has.
  SpindleRun(PreparedSpindle& spindle, Clock& clock, const std::atomic<std::uint64_t>& log_lines_dropped);
  ~SpindleRun() { stop(); }
  SpindleRun(const SpindleRun&) = delete;
  SpindleRun& operator=(const SpindleRun&) = delete;

  /// Reads checkpoint and standing orders; before the server that takes new orders.
  void recall();
  /// What the Modbus server needs.
  SpindlePorts ports();
  const Pulse& pulse() const { return pulse_; }

  /// Where HTTP port and plant network look; null: that one is not there.
  using ShownTo = std::array<Latest<Snapshot>*, 2>;

  /// Goes on from the checkpoint and starts all threads. Takes seconds after a long pause; gives up where end() is
  /// called meanwhile, in another thread.
  void begin(const ShownTo& shown);
  /// No work is begun any more, and begin() returns soon. Any thread.
  void end() { stop_.store(true); }
  /// Ends all threads and keeps what the cycle knows. Not while begin() runs.
  void stop();

 private:
  template <class Work>
  void run(std::vector<std::thread>& threads, Work work);
  CyclePorts cycle_ports(const ShownTo& shown);

  PreparedSpindle& spindle_;
  Clock& clock_;
  Troubles troubles_;
  DeviceInbox readings_;
  Latest<PlcSignals> signals_;
  Latest<Snapshot> snapshots_;
  OrderDesk desk_;
  OrderKeeper order_keeper_;
  std::vector<std::unique_ptr<DeviceThread>> devices_;
  EventLog events_;
  std::unique_ptr<HistoryWriter> history_;
  std::optional<Checkpoint> checkpoint_;  ///< until begin()
  StandingOrders orders_;
  std::optional<Keeper> keeper_;
  NetworkExchange exchange_;
  std::optional<SlotWatch> slot_;  ///< empty: no slot is configured
  Pulse pulse_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> stop_after_cycle_{false};
  std::vector<std::thread> threads_;
  std::vector<std::thread> after_cycle_;  ///< until nothing more comes from the cycle
};

}  // namespace spindle_twin::firmware
