#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/keep/keep_plan.hpp"
#include "firmware/watch/log_limit.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// Writes each cycle's snapshot as a row, in the thread that calls run(); the cycle thread only fills the ring. While
/// nothing can be written rows are lost and counted, the fault history_lost is up, and each second it is tried again.
class HistoryWriter {
 public:
  virtual ~HistoryWriter() = default;
  HistoryWriter(const HistoryWriter&) = delete;
  HistoryWriter& operator=(const HistoryWriter&) = delete;

  SnapshotRing& ring() { return ring_; }
  std::atomic<std::uint64_t>& lost() { return lost_; }

  /// Until `stop` is set; what is in the ring then is still written.
  void run(const std::atomic<bool>& stop);

 protected:
  HistoryWriter(std::string path, Troubles& troubles);

  /// Writes what is in the ring, or loses it; for run().
  virtual void drain() = 0;

  /// A thing went wrong for `reason`: nothing is to be tried for a second.
  void complain(const std::string& what, const std::string& reason);
  bool may_try() const;
  /// It is written, again.
  void works();
  void lose(std::uint64_t rows) { lost_ += rows; }
  /// The file is open now: remembers which one it is.
  void note_file();
  /// Somebody has removed or replaced it: what is written goes nowhere. False before note_file().
  bool is_gone() const;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  Troubles& troubles_;
  std::int64_t try_from_ns_ = 0;
  std::uint64_t device_ = 0, inode_ = 0;  ///< of the open file; 0: not known
  SnapshotRing ring_;
  std::atomic<std::uint64_t> lost_{0};
  LogLimit complaints_;
};

/// A History, or where the path ends in .sqlite a SqliteHistory.
std::unique_ptr<HistoryWriter> make_history(const HistoryPlan& plan, const rom::Network& network, Troubles& troubles);

}  // namespace spindle_twin::firmware
