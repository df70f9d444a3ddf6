#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/keep/database.hpp"
#include "firmware/keep/history_writer.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// Whether a history of this name is a database.
bool is_sqlite_path(const std::string& path);

/// A history in an SQLite file (WAL): the table `cycle` with a row per cycle, its columns those of history_header()
/// behind id, run and unix_s (indexed), the numbers as the daemon has them; the table `run` with a row per start and
/// gap, whose id is that of its first cycle. What was committed outlives a crash, and the file is readable at any
/// moment. Rows older than most_days go, by the time that passes while the
/// daemon runs and at most two for each new one, and the oldest when the rows take more than most_bytes; the file keeps
/// its size then. A file that is damaged, or of other columns, gets a number as an earlier history. On a full disk
/// nothing is deleted.
class SqliteHistory final : public HistoryWriter {
 public:
  SqliteHistory(HistoryPlan plan, const rom::Network& network, Troubles& troubles);

 protected:
  void drain() override;

 private:
  bool open();
  void open_file();
  void make_tables();
  bool has_our_tables();
  void put_aside();
  void add(const Snapshot& snapshot, double clock_offset_s);
  void begin_aging();
  void give_up_removed();
  std::int64_t last_to_remove(int too_old_at_once);
  void remove_old(int too_old_at_once);
  void fail(const char* what, const DatabaseError& error);

  HistoryPlan plan_;
  std::string spindle_;
  std::vector<std::string> columns_;
  std::optional<Database> database_;
  std::optional<Statement> insert_;
  /// Rows grow old by the time since then: what happens to the clock on the wall meanwhile makes none older.
  double began_unix_s_ = unix_now_s();
  std::int64_t began_ns_ = MonotonicClock().now_ns();
  bool is_damaged_ = false;
  std::uint64_t most_bytes_ = 0;  ///< of this file
  std::int64_t next_id_ = 1;
  std::int64_t run_ = 0;          ///< 0: the next row begins one
  std::uint64_t sequence_ = 0;    ///< of the last row
  std::uint32_t network_id_ = 0;  ///< likewise
  std::vector<double> numbers_;
};

}  // namespace spindle_twin::firmware
