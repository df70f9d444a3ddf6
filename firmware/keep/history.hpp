#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/cycle/cycle.hpp"
#include "firmware/cycle/troubles.hpp"
#include "firmware/keep/history_row.hpp"
#include "firmware/keep/keep_plan.hpp"
#include "firmware/watch/log_limit.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// The files of a history that are no longer written, oldest first: of twin.csv these are twin.000001.csv and so on.
std::vector<std::string> earlier_histories(const std::string& path);

/// Writes each cycle's snapshot as a row, in the thread that calls run(); the cycle thread only fills the ring. Each
/// start, each gap and each segment_bytes begin a file; the one before gets the next number, and the oldest go when
/// all together are more than most_bytes. So every file replays by itself. Rows are written whole: what a full disk or
/// a power cut leaves of one is cut off. While nothing can be written rows are lost and counted, the fault history_lost
/// is up, and each second it is tried again.
class History {
 public:
  History(HistoryPlan plan, const rom::Network& network, Troubles& troubles);
  ~History();
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  SnapshotRing& ring() { return ring_; }
  std::atomic<std::uint64_t>& lost() { return lost_; }

  /// Until `stop` is set; what is in the ring then is still written.
  void run(const std::atomic<bool>& stop);

 private:
  bool begin_file();
  void drain();
  void write_rows(const std::string& rows, std::uint64_t count);
  void close_file();
  void complain(const char* what);

  HistoryPlan plan_;
  std::string header_;
  Troubles& troubles_;
  int file_ = -1;
  std::uint64_t written_ = 0;   ///< bytes of whole rows
  std::uint64_t sequence_ = 0;  ///< of the last row
  std::int64_t try_from_ns_ = 0;
  SnapshotRing ring_;
  std::atomic<std::uint64_t> lost_{0};
  LogLimit complaints_;
};

}  // namespace spindle_twin::firmware
