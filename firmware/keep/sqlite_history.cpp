#include "firmware/keep/sqlite_history.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <utility>

#include "firmware/keep/history.hpp"
#include "firmware/keep/history_row.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr std::int64_t our_application_id = 0x53545748;  ///< "STWH"
constexpr std::int64_t our_version = 1;
constexpr int rows_in_a_transaction = 64;
constexpr int removed_at_once = 256;
constexpr std::uint64_t removed_for_each = 2;  ///< too old rows go no faster: a clock that leaps costs few
constexpr double seconds_per_day = 86400.0;

std::vector<std::string> split(const std::string& header) {
  std::vector<std::string> names;
  std::istringstream stream(header);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

}  // namespace

bool is_sqlite_path(const std::string& path) { return path.ends_with(".sqlite"); }

SqliteHistory::SqliteHistory(HistoryPlan plan, const rom::Network& network, Troubles& troubles)
    : HistoryWriter(plan.path, troubles),
      plan_(std::move(plan)),
      spindle_(network.spindle),
      columns_(split(history_header(network))) {
  open();
}

void SqliteHistory::make_tables() {
  std::string sql =
      "BEGIN; CREATE TABLE run (id INTEGER PRIMARY KEY, began_unix_s REAL NOT NULL, spindle TEXT NOT NULL);"
      "CREATE TABLE cycle (id INTEGER PRIMARY KEY, run INTEGER NOT NULL, unix_s REAL NOT NULL";
  for (const std::string& column : columns_) sql.append(", ").append(quoted_name(column)).append(" REAL");
  sql += "); CREATE INDEX cycle_by_time ON cycle (unix_s);";
  sql += fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}; COMMIT;", our_application_id, our_version);
  database_->run(sql);
}

bool SqliteHistory::has_our_tables() {
  if (database_->whole("PRAGMA application_id") != our_application_id) return false;
  if (database_->whole("PRAGMA user_version") != our_version) return false;
  Statement names = database_->prepare("SELECT name FROM pragma_table_info('cycle') WHERE cid > 2 ORDER BY cid");
  std::vector<std::string> found;
  while (names.step()) found.push_back(names.text(0));
  return found == columns_;
}

void SqliteHistory::put_aside() {
  insert_.reset();
  database_.reset();  // and with it its WAL
  const std::string aside = next_earlier_history(path());
  for (const char* end : {"-wal", "-shm", ""}) {
    std::remove((aside + end).c_str());  // of a file that is gone: it would be taken for this one's
    if (std::rename((path() + end).c_str(), (aside + end).c_str()) != 0 && errno != ENOENT) {
      throw DatabaseError(0, std::string("cannot be put aside: ") + std::strerror(errno));
    }
  }
}

void SqliteHistory::open_file() {
  database_.emplace(path(), Database::Mode::write);
  database_->run("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA journal_size_limit = 4194304;");
  if (database_->whole("SELECT count(*) FROM sqlite_schema") == 0) {
    make_tables();
  } else if (!has_our_tables()) {
    put_aside();
    open_file();
  }
}

/// Rows grow old by the time that passes while the daemon runs: from now on, or where the clock on the wall says a
/// later time than the newest row, from that row on, as the clock may be wrong.
void SqliteHistory::begin_aging() {
  began_ns_ = MonotonicClock().now_ns();
  began_unix_s_ = unix_now_s();
  Statement newest = database_->prepare("SELECT unix_s FROM cycle ORDER BY id DESC LIMIT 1");
  if (!newest.step()) return;
  const double newest_s = newest.number(0);
  if (began_unix_s_ - newest_s > seconds_per_day * plan_.most_days) {
    spdlog::warn(
        "history {}: its last row is {:.0f} days old by the clock, which may be wrong; rows go as they grow old "
        "while the daemon runs",
        path(), (began_unix_s_ - newest_s) / seconds_per_day);
  }
  began_unix_s_ = std::min(began_unix_s_, newest_s);
}

/// A file that somebody removed or replaced is given up; the next row begins another.
void SqliteHistory::give_up_removed() {
  if (!database_ || !is_gone()) return;
  insert_.reset();
  database_.reset();
  complain("was removed or replaced", std::strerror(ENOENT));
  open();
}

/// False where that is not possible now; it has been complained about.
bool SqliteHistory::open() {
  run_ = 0;
  try {
    if (std::exchange(is_damaged_, false)) put_aside();
    open_file();
    most_bytes_ = plan_.most_bytes - remove_oldest_histories(path(), plan_.most_bytes / 2);
    next_id_ = 1 + database_->whole(
                       "SELECT max(coalesce((SELECT max(id) FROM cycle), 0), "
                       "coalesce((SELECT max(id) FROM run), 0))");
    std::string places;
    for (std::size_t i = 0; i < columns_.size() + 3; ++i) places += i == 0 ? "?" : ",?";
    insert_.emplace(database_->prepare("INSERT INTO cycle VALUES (" + places + ")"));
    note_file();
    begin_aging();
    return true;
  } catch (const DatabaseError& error) {
    fail("cannot be opened", error);
    return false;
  }
}

/// What was not committed is gone with the connection. A damaged file gives way when the next one is opened.
void SqliteHistory::fail(const char* what, const DatabaseError& error) {
  is_damaged_ = error.is_damage();
  insert_.reset();
  database_.reset();
  complain(what, error.what());
}

void SqliteHistory::add(const Snapshot& snapshot, double clock_offset_s) {
  const double unix_s = clock_offset_s + 1e-9 * static_cast<double>(snapshot.time_ns);
  // One network replays a run.
  if (run_ == 0 || snapshot.sequence != sequence_ + 1 || snapshot.network_id != network_id_) {
    run_ = next_id_;
    Statement begin = database_->prepare("INSERT INTO run VALUES (?, ?, ?)");
    begin.bind(0, run_);
    begin.bind(1, unix_s);
    begin.bind(2, spindle_);
    begin.run();
  }
  sequence_ = snapshot.sequence;
  network_id_ = snapshot.network_id;
  history_numbers(snapshot, numbers_);
  insert_->bind(0, next_id_++);
  insert_->bind(1, run_);
  insert_->bind(2, unix_s);
  for (std::size_t i = 0; i < numbers_.size(); ++i) insert_->bind(static_cast<int>(i) + 3, numbers_[i]);
  insert_->run();
}

/// The id up to which rows go: the too old ones, and where there are too many an eighth; a few at a time, as the rows
/// that come meanwhile wait in the ring. 0: none.
std::int64_t SqliteHistory::last_to_remove(int too_old_at_once) {
  // Not one behind a younger row: where the clock on the wall was set, times are not in the order of the rows.
  Statement too_old = database_->prepare(
      fmt::format("WITH first AS (SELECT id, unix_s FROM cycle ORDER BY id LIMIT {}) SELECT max(id) FROM first "
                  "WHERE id < coalesce((SELECT min(id) FROM first WHERE unix_s >= ?), 9223372036854775807)",
                  too_old_at_once));
  const double now_s = began_unix_s_ + 1e-9 * static_cast<double>(MonotonicClock().now_ns() - began_ns_);
  too_old.bind(0, now_s - seconds_per_day * plan_.most_days);
  too_old.step();
  const std::int64_t pages = database_->whole("PRAGMA page_count") - database_->whole("PRAGMA freelist_count");
  if (pages * database_->whole("PRAGMA page_size") <= static_cast<std::int64_t>(most_bytes_)) return too_old.whole(0);
  const std::int64_t first = database_->whole("SELECT min(id) FROM cycle");
  return std::max(too_old.whole(0), first + std::clamp<std::int64_t>((next_id_ - first) / 8, 1, removed_at_once) - 1);
}

void SqliteHistory::remove_old(int too_old_at_once) {
  const std::int64_t last = last_to_remove(too_old_at_once);
  if (last == 0) return;
  database_->run(
      fmt::format("BEGIN; DELETE FROM cycle WHERE id <= {}; "
                  "DELETE FROM run WHERE id < (SELECT run FROM cycle ORDER BY id LIMIT 1); COMMIT;",
                  last));
}

void SqliteHistory::drain() {
  while (ring().size() > 0) {
    Snapshot snapshot;
    give_up_removed();
    const bool is_open = database_ || (may_try() && open());
    std::uint64_t taken = 0;
    try {
      if (is_open) database_->run("BEGIN");
      const double clock_offset_s = unix_now_s() - 1e-9 * static_cast<double>(MonotonicClock().now_ns());
      while (taken < rows_in_a_transaction && ring().pop(snapshot)) {
        ++taken;
        if (is_open) add(snapshot, clock_offset_s);
      }
      if (!is_open) {
        lose(taken);
        continue;
      }
      database_->run("COMMIT");
      works();
      remove_old(static_cast<int>(removed_for_each * std::exchange(taken, 0)));
    } catch (const DatabaseError& error) {
      lose(taken);
      fail("cannot be written", error);
    }
  }
}

}  // namespace spindle_twin::firmware
