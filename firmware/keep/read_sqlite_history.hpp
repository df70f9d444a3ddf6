#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rom/read/csv_table.hpp"

namespace spindle_twin::firmware {

/// What a daemon wrote without a gap.
struct HistoryRun {
  std::int64_t id = 0;
  std::string spindle;
  double first_unix_s = 0.0;  ///< of the rows that are left
  double last_unix_s = 0.0;
  std::int64_t first_row = 0;  ///< its id
  std::int64_t rows = 0;
};

/// Whether the file begins as a database does.
bool is_sqlite_file(const std::string& path);

/// Reads what SqliteHistory writes, also while it writes. Every function throws rom::InputError naming the file, and
/// what else was wrong: no history, of a newer version, no run of that number.
class SqliteHistoryReader {
 public:
  explicit SqliteHistoryReader(std::string path);
  ~SqliteHistoryReader();
  SqliteHistoryReader(const SqliteHistoryReader&) = delete;
  SqliteHistoryReader& operator=(const SqliteHistoryReader&) = delete;

  /// Those that have rows, oldest first; one at least.
  const std::vector<HistoryRun>& runs() const;
  /// Names as in history_header().
  const std::vector<std::string>& columns() const;
  /// Calls `take` with each row of a run in order; empty: the last run. NaN: no value.
  void each_row(std::optional<std::int64_t> run, const std::function<void(std::span<const double>)>& take) const;
  /// The same as a table; its lines count the run's rows from 1.
  rom::CsvTable table(std::optional<std::int64_t> run) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace spindle_twin::firmware
