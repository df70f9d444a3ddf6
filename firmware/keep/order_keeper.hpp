#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/orders_file.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Before the cycle's first step: the orders that hold from the run before, whatever their age, and in the log what
/// became of them. `lost` where there were orders that this run does not have: the file is damaged, older than the
/// checkpoint says, missing beside a checkpoint that knew of one, or has tares of another network. The checkpoint's
/// tares then stand in where it is of this network. Empty path: nothing holds. `sha256_before`: the network that this
/// one took the place of; a kill between its file and the orders' leaves orders of that one, which hold.
StandingOrders recall_orders(const std::string& path, const std::string& network_sha256,
                             const std::optional<Checkpoint>& checkpoint, const std::string& sha256_before = {});

/// Writes standing orders to the disk as soon as the cycle has obeyed one, in the thread that calls run(), and tells
/// the desk. What cannot be written is tried again each second; until then the fault orders_not_kept is up.
class OrderKeeper {
 public:
  OrderKeeper(std::string path, std::string network_sha256, OrderDesk& desk, Troubles& troubles);

  /// Puts what was recalled on the disk and on the desk. Before any thread runs.
  void begin_with(const StandingOrders& recalled);

  /// Until `stop` is set; what the cycle has left by then is still written.
  void run(const std::atomic<bool>& stop);

  /// How many orders are on the disk. Any thread.
  std::uint32_t revision() const { return revision_.load(std::memory_order_acquire); }

 private:
  bool keep();

  std::string path_;
  OrderDesk& desk_;
  Troubles& troubles_;
  KeptOrders kept_;
  std::atomic<std::uint32_t> revision_{0};
  LogLimit complaints_;
};

}  // namespace spindle_twin::firmware
