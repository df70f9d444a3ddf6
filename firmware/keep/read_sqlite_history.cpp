#include "firmware/keep/read_sqlite_history.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <utility>

#include "firmware/keep/database.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr int first_value = 3;  ///< behind id, run and unix_s

template <class Work>
auto or_say_so(const std::string& path, Work work) {
  try {
    return work();
  } catch (const DatabaseError& error) {
    throw rom::InputError({path, 0}, "", std::string("cannot be read as a history in SQLite: ") + error.what());
  }
}

double time_of(Database& database, std::int64_t cycle) {
  Statement row = database.prepare("SELECT unix_s FROM cycle WHERE id = ?");
  row.bind(0, cycle);
  row.step();
  return row.number(0);
}

std::int64_t first_row(Database& database) { return database.whole("SELECT min(id) FROM cycle"); }

/// Ids of cycles follow each other, a run has that of its first one, and the oldest cycles may be gone.
std::vector<HistoryRun> read_runs(const std::string& path, Database& database) {
  const std::int64_t first = first_row(database);
  const std::int64_t last = database.whole("SELECT max(id) FROM cycle");
  if (last == 0) return {};
  const auto damaged = [&](const std::string& reason) {
    return rom::InputError({path, 0}, "run", reason + ": the file is damaged");
  };
  constexpr std::int64_t most_rows = 1LL << 53;  // of a table's numbers
  if (first < 1 || last >= most_rows) throw damaged(fmt::format("rows have the numbers {} to {}", first, last));
  std::int64_t end = last + 1;
  std::vector<HistoryRun> runs;
  Statement run = database.prepare("SELECT id, spindle FROM run ORDER BY id DESC");
  while (end > first && run.step()) {
    if (run.whole(0) >= end) throw damaged(fmt::format("{} begins behind its last row", run.whole(0)));
    const std::int64_t from = std::max(run.whole(0), first);
    runs.push_back({run.whole(0), run.text(1), time_of(database, from), time_of(database, end - 1), from, end - from});
    end = from;
  }
  std::reverse(runs.begin(), runs.end());
  return runs;
}

}  // namespace

struct SqliteHistoryReader::Parts {
  std::string path;
  Database database;
  std::vector<std::string> columns = {};
  std::vector<HistoryRun> runs = {};
};

bool is_sqlite_file(const std::string& path) {
  constexpr std::string_view magic("SQLite format 3\0", 16);
  std::array<char, magic.size()> begin{};
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == magic;
}

SqliteHistoryReader::SqliteHistoryReader(std::string path) {
  parts_ = or_say_so(path, [&] { return std::make_unique<Parts>(Parts{path, Database(path, Database::Mode::read)}); });
  or_say_so(path, [&] {
    Database& database = parts_->database;
    if (database.whole("SELECT count(*) FROM sqlite_schema WHERE name IN ('run', 'cycle')") != 2) {
      throw rom::InputError({path, 0}, "", "is no history of spindle-twind");
    }
    if (const std::int64_t version = database.whole("PRAGMA user_version"); version != 1) {
      throw rom::InputError({path, 0}, "user_version", fmt::format("is {}; this program reads 1", version));
    }
    const Statement row = database.prepare("SELECT * FROM cycle");
    for (int c = first_value; c < row.columns(); ++c) parts_->columns.push_back(row.column_name(c));
    parts_->runs = read_runs(path, database);
  });
  if (parts_->runs.empty()) throw rom::InputError({path, 0}, "", "this history has no row yet");
}

SqliteHistoryReader::~SqliteHistoryReader() = default;

const std::vector<HistoryRun>& SqliteHistoryReader::runs() const { return parts_->runs; }
const std::vector<std::string>& SqliteHistoryReader::columns() const { return parts_->columns; }

void SqliteHistoryReader::each_row(std::optional<std::int64_t> run,
                                   const std::function<void(std::span<const double>)>& take) const {
  const std::vector<HistoryRun>& runs = parts_->runs;
  const std::int64_t id = run.value_or(runs.back().id);
  const auto wanted = std::find_if(runs.begin(), runs.end(), [&](const HistoryRun& each) { return each.id == id; });
  if (wanted == runs.end()) {
    std::vector<std::int64_t> ids;
    ids.reserve(runs.size());
    for (const HistoryRun& each : runs) ids.push_back(each.id);
    throw rom::InputError({parts_->path, 0}, "run",
                          fmt::format("there is no {}; allowed: {}", id, fmt::join(ids, ", ")));
  }
  or_say_so(parts_->path, [&] {
    Statement rows = parts_->database.prepare("SELECT * FROM cycle WHERE id >= ? AND id < ? ORDER BY id");
    rows.bind(0, wanted->first_row);
    rows.bind(1, wanted->first_row + wanted->rows);
    std::vector<double> values(parts_->columns.size());
    std::int64_t count = 0;
    for (; rows.step(); ++count) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = rows.number(static_cast<int>(i) + first_value);
      take(values);
    }
    // A daemon that writes may have let its oldest rows go since the runs were counted.
    const std::int64_t oldest = count == wanted->rows ? wanted->first_row : first_row(parts_->database);
    const std::int64_t expected = wanted->first_row + wanted->rows - std::max(wanted->first_row, oldest);
    if (count < expected || count > wanted->rows) {
      throw rom::InputError(
          {parts_->path, 0}, "run",
          fmt::format("{} has {} rows, {} by their numbers: the file is damaged", id, count, expected));
    }
  });
}

rom::CsvTable SqliteHistoryReader::table(std::optional<std::int64_t> run) const {
  rom::CsvTable table;
  table.file = parts_->path;
  table.names = parts_->columns;
  table.header_line = 0;
  table.columns.resize(table.names.size());
  each_row(run, [&](std::span<const double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) table.columns[i].push_back(values[i]);
    table.lines.push_back(static_cast<int>(table.lines.size()) + 1);
  });
  return table;
}

}  // namespace spindle_twin::firmware
