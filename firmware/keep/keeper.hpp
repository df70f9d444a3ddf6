#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/keep_plan.hpp"
#include "firmware/keep/order_keeper.hpp"

namespace spindle_twin::firmware {

/// The checkpoint as it stands; empty without one, and where it cannot be used, which the log then says.
std::optional<Checkpoint> look_for_checkpoint(const KeepPlan& plan);

/// Where and when the daemon starts.
struct StartingPoint {
  const std::string& network_sha256;
  double clock_rate = 1.0;    ///< model seconds per second of the clock
  double now_unix_s = 0.0;    ///< by the clock that the checkpoint's time was taken from
  BootTime now = boot_now();  ///< in the checkpoint's boot this counts: the clock on the wall may have been set since
};

/// Before the cycle's first step: goes on from the checkpoint where there is one that fits, and says in the log what
/// became of it. Of another network, too old, from the future, damaged: the start is as without one. `stop` as in
/// Cycle::resume().
Resumed resume_from_checkpoint(const KeepPlan& plan, const std::optional<Checkpoint>& checkpoint,
                               const StartingPoint& start, Cycle& cycle, const std::atomic<bool>* stop = nullptr);

/// When the next checkpoint is due behind one that was due at `due`: an interval later, an interval after `now` where
/// that has passed; where it was not `kept`, a second after `now` if that is sooner. The keeper's thread only.
std::chrono::steady_clock::time_point next_checkpoint(std::chrono::steady_clock::time_point due,
                                                      std::chrono::steady_clock::time_point now,
                                                      std::chrono::steady_clock::duration interval, bool kept);

/// Writes the checkpoint and the table of parameters each interval, and once an hour says in the log what the sensors
/// determine, in the thread that calls run(); the cycle thread only copies what it is asked for. What cannot be written
/// raises the fault checkpoint_lost and is tried again each second.
class Keeper {
 public:
  /// Sizes what the cycle fills. The checkpoint says how many orders were on the disk; null: none.
  Keeper(KeepPlan plan, std::string network_sha256, double clock_rate, const Cycle& cycle,
         const OrderKeeper* orders = nullptr, Troubles* troubles = nullptr);

  OnRequest<Remembered>& remembered() { return remembered_; }

  /// A checkpoint at once, without waiting for its interval. Any thread.
  void keep_now() { keep_now_.store(true, std::memory_order_release); }

  /// Until `stop` is set.
  void run(const std::atomic<bool>& stop);

  /// Keeps what `cycle` knows now; for the end, when no thread runs it any more.
  void keep_last(const Cycle& cycle);

 private:
  /// False where something could not be written.
  bool keep(bool say);

  KeepPlan plan_;
  std::string network_sha256_;
  double clock_rate_;
  std::vector<correction::Parameter> parameters_;
  OnRequest<Remembered> remembered_;
  const OrderKeeper* orders_;
  Troubles* troubles_;
  LogLimit complaints_;
  std::atomic<bool> keep_now_{false};
  double said_at_s_ = 0.0;
  std::string heats_said_;  // of unexplained heats, the sentence said last
};

}  // namespace spindle_twin::firmware
