#include "firmware/keep/read_sqlite_history.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/keep/database.hpp"
#include "rom/read/input_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_read_sqlite_history_test {

/// A file as the daemon makes it, with rows by hand: the number a is ten times the row's, b is none.
class HistoryFile : public ::testing::Test {
 protected:
  HistoryFile() {
    run("PRAGMA user_version = 1; CREATE TABLE run (id INTEGER PRIMARY KEY, began_unix_s REAL, spindle TEXT);"
        "CREATE TABLE cycle (id INTEGER PRIMARY KEY, run INTEGER, unix_s REAL, a REAL, b REAL)");
  }
  void run(const std::string& sql) const { Database(path_, Database::Mode::write).run(sql); }
  void begin_run(std::int64_t id, const std::string& spindle = "small") const {
    run("INSERT INTO run VALUES (" + std::to_string(id) + ", 0, '" + spindle + "')");
  }
  void add_rows(std::int64_t first, std::int64_t last) const {
    for (std::int64_t id = first; id <= last; ++id) {
      const std::string number = std::to_string(id);
      run("INSERT INTO cycle VALUES (" + number + ", 1, 1000 + " + number + ", 10 * " + number + ", NULL)");
    }
  }
  std::vector<HistoryRun> runs() const { return SqliteHistoryReader(path_).runs(); }
  std::string error_of(std::optional<std::int64_t> of_run = std::nullopt) const {
    try {
      SqliteHistoryReader(path_).table(of_run);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("history.sqlite");
};

TEST_F(HistoryFile, a_run_reaches_from_its_row_to_the_next_runs_and_what_is_left_of_the_oldest_counts) {
  begin_run(1, "first");
  add_rows(1, 3);
  begin_run(4, "second");
  add_rows(4, 4);
  begin_run(5);
  add_rows(5, 9);
  run("DELETE FROM cycle WHERE id < 2");
  const std::vector<HistoryRun> told = runs();
  ASSERT_EQ(told.size(), 3U);
  struct Expected {
    std::int64_t id, first_row, rows;
    const char* spindle;
  };
  const std::vector<Expected> expected{{1, 2, 2, "first"}, {4, 4, 1, "second"}, {5, 5, 5, "small"}};
  const SqliteHistoryReader reader(path_);
  EXPECT_EQ(reader.columns(), (std::vector<std::string>{"a", "b"}));
  for (std::size_t n = 0; n < 3; ++n) {
    const Expected& of = expected[n];
    EXPECT_EQ(told[n].id, of.id);
    EXPECT_EQ(told[n].spindle, of.spindle);
    EXPECT_EQ(told[n].first_row, of.first_row);
    EXPECT_EQ(told[n].rows, of.rows);
    EXPECT_EQ(told[n].first_unix_s, 1000.0 + static_cast<double>(of.first_row));
    EXPECT_EQ(told[n].last_unix_s, 999.0 + static_cast<double>(of.first_row + of.rows));
    const rom::CsvTable table = reader.table(of.id);
    ASSERT_EQ(table.rows(), static_cast<std::size_t>(of.rows));
    EXPECT_EQ(table.header_line, 0);
    for (std::size_t i = 0; i < table.rows(); ++i) {
      EXPECT_EQ(table.column("a")[i], 10.0 * static_cast<double>(of.first_row + static_cast<std::int64_t>(i)));
      EXPECT_TRUE(std::isnan(table.column("b")[i]));
      EXPECT_EQ(table.lines[i], static_cast<int>(i) + 1);
    }
  }
  EXPECT_EQ(reader.table(std::nullopt).rows(), 5U);
  EXPECT_EQ(error_of(2), path_ + ": run: there is no 2; allowed: 1, 4, 5");
  run("DELETE FROM cycle WHERE id < 4");
  EXPECT_EQ(runs().size(), 2U) << "of the first no row is left";
  EXPECT_EQ(runs()[0].id, 4);
}

TEST_F(HistoryFile, one_row_is_a_history_and_none_is_not) {
  EXPECT_EQ(error_of(), path_ + ": this history has no row yet");
  begin_run(1);
  add_rows(1, 1);
  ASSERT_EQ(runs().size(), 1U);
  EXPECT_EQ(runs()[0].rows, 1);
}

TEST_F(HistoryFile, rows_without_a_number_that_a_daemon_gives_are_damage) {
  begin_run(9'007'199'254'740'991);
  run("INSERT INTO cycle VALUES (9007199254740991, 1, 0, 0, 0)");
  EXPECT_EQ(runs().at(0).rows, 1) << "the last number that a table of numbers holds";
  run("INSERT INTO cycle VALUES (9007199254740992, 1, 0, 0, 0)");
  EXPECT_EQ(error_of(),
            path_ + ": run: rows have the numbers 9007199254740991 to 9007199254740992: the file is damaged");
  run("DELETE FROM cycle; DELETE FROM run");
  begin_run(1);
  add_rows(0, 2);
  EXPECT_EQ(error_of(), path_ + ": run: rows have the numbers 0 to 2: the file is damaged");
}

TEST_F(HistoryFile, a_run_that_begins_behind_the_last_row_is_damage) {
  for (const std::int64_t behind : {4, 7}) {
    run("DELETE FROM cycle; DELETE FROM run");
    begin_run(1);
    add_rows(1, 3);
    EXPECT_EQ(error_of(), "no error");
    begin_run(behind);
    EXPECT_EQ(error_of(),
              path_ + ": run: " + std::to_string(behind) + " begins behind its last row: the file is damaged");
  }
}

TEST_F(HistoryFile, what_is_no_such_history_is_one_clear_error) {
  run("PRAGMA user_version = 0");
  EXPECT_EQ(error_of(), path_ + ": user_version: is 0; this program reads 1");
  run("PRAGMA user_version = 2");
  EXPECT_EQ(error_of(), path_ + ": user_version: is 2; this program reads 1");
  run("DROP TABLE run");
  EXPECT_EQ(error_of(), path_ + ": is no history of spindle-twind");
  path_ = folder_.file("missing.sqlite");
  EXPECT_EQ(error_of(), path_ + ": cannot be read as a history in SQLite: unable to open database file");
}

TEST_F(HistoryFile, a_file_is_a_database_by_how_it_begins) {
  EXPECT_TRUE(is_sqlite_file(path_));
  EXPECT_TRUE(is_sqlite_file(folder_.write("begin", std::string("SQLite format 3\0and so on", 25))));
  EXPECT_FALSE(is_sqlite_file(folder_.write("other", std::string("SQLite format 4\0and so on", 25))));
  EXPECT_FALSE(is_sqlite_file(folder_.write("text", "SQLite format 3 is a format")));
  EXPECT_FALSE(is_sqlite_file(folder_.file("missing")));
}

}  // namespace keep_read_sqlite_history_test
}  // namespace spindle_twin::firmware
