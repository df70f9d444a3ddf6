#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "firmware/keep/database.hpp"
#include "firmware/keep/history.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/keep/sqlite_file.hpp"

namespace spindle_twin::firmware {
namespace keep_sqlite_aging_test {

TEST_F(SqliteFile, the_oldest_rows_go_when_there_are_too_many_and_the_file_stays_as_large) {
  HistoryPlan plan{path_};
  plan.most_bytes = 512 << 10;
  SqliteHistory history(plan, network_, troubles_);
  write_cycles(history, 1, 8000);
  EXPECT_EQ(history.lost().load(), 0U);
  const rom::CsvTable kept = table();
  EXPECT_LT(kept.rows(), 5000U);
  EXPECT_GT(kept.rows(), 500U);
  EXPECT_EQ(kept.column("sequence").back(), 8000.0);
  EXPECT_LT(std::filesystem::file_size(path_), plan.most_bytes + (256 << 10));
}

TEST_F(SqliteFile, rows_older_than_most_days_go_and_runs_without_rows_with_them) {
  change_ = [](Snapshot& snapshot) { snapshot.time_ns -= std::int64_t{3} * 86400 * 1'000'000'000; };
  write_run(100);
  change_ = [](Snapshot&) {};
  HistoryPlan plan{path_};
  plan.most_days = 2.0;
  const auto write_more = [&](std::uint64_t rows) {
    SqliteHistory history(plan, network_, troubles_);
    write_cycles(history, 1, rows);
  };
  write_more(10);
  ASSERT_EQ(runs().size(), 2U);
  EXPECT_EQ(runs()[0].rows, 100) << "the clock may be wrong: nothing goes by its leap";
  write_more(10);
  ASSERT_EQ(runs().size(), 3U);
  EXPECT_GE(runs()[0].rows, 80) << "two at most for each new one";
  EXPECT_LT(runs()[0].rows, 100);
  write_more(100);
  ASSERT_EQ(runs().size(), 3U);
  EXPECT_EQ(runs()[0].rows, 10);
  EXPECT_EQ(runs()[0].id, 101);
}

TEST_F(SqliteFile, rows_of_a_clock_that_was_wrong_for_a_while_take_no_younger_ones_with_them) {
  HistoryPlan plan{path_};
  plan.most_days = 2.0;
  SqliteHistory history(plan, network_, troubles_);
  write_cycles(history, 1, 100);
  change_ = [](Snapshot& snapshot) { snapshot.time_ns -= std::int64_t{9000} * 86400 * 1'000'000'000; };
  write_cycles(history, 101, 110);
  change_ = [](Snapshot&) {};
  write_cycles(history, 111, 200);
  EXPECT_EQ(table().rows(), 200U);
}

TEST_F(SqliteFile, a_row_goes_once_it_is_older_than_most_days_and_not_a_minute_before) {
  HistoryPlan plan{path_};
  plan.most_days = 3.0;
  constexpr std::int64_t days_s = 3 * 86400;
  SqliteHistory history(plan, network_, troubles_);
  write_at_once(history, cycles_at(network_, {days_s + 9000, days_s + 60, days_s - 60, 10}));
  EXPECT_EQ(table().rows(), 2U);
  EXPECT_EQ(table().column("sequence").front(), 3.0);
}

/// Of one that is full an eighth goes, whether it holds thousands or a hundred.
TEST_F(SqliteFile, a_small_one_that_is_full_keeps_most_of_its_rows) {
  HistoryPlan plan{path_};
  plan.most_bytes = 96 << 10;
  SqliteHistory history(plan, network_, troubles_);
  Database reader(path_, Database::Mode::read);
  std::int64_t most = 0;
  for (std::uint64_t n = 0; n < 12; ++n) {
    std::vector<Snapshot> cycles = cycles_at(network_, std::vector<std::int64_t>(64, 0));
    for (Snapshot& cycle : cycles) cycle.sequence += 64 * n;
    write_at_once(history, cycles);
    const std::int64_t rows = reader.whole("SELECT count(*) FROM cycle");
    most = std::max(most, rows);
    EXPECT_GT(rows, most - most / 6) << n;
  }
  std::vector<Snapshot> one = cycles_at(network_, {0});
  for (one[0].sequence = 12 * 64 + 1; one[0].sequence <= 12 * 64 + 20; ++one[0].sequence) write_at_once(history, one);
  EXPECT_GT(reader.whole("SELECT count(*) FROM cycle"), most - most / 6) << "what is free in the file counts not";
  EXPECT_GT(most, 128);
  EXPECT_LT(most, 12 * 64) << "it was full";
}

TEST_F(SqliteFile, half_of_the_bytes_are_for_those_put_aside_and_it_has_what_they_leave) {
  constexpr std::int64_t most = 256 << 10, slack = 32 << 10;
  for (const bool fits : {true, false}) {
    for (const auto& each : std::filesystem::directory_iterator(folder_.path())) std::filesystem::remove(each.path());
    const std::string earlier = folder_.write("history.000001.sqlite", "x");
    std::filesystem::resize_file(earlier, static_cast<std::uintmax_t>(most / 2 + (fits ? 0 : 1)));
    HistoryPlan plan{path_};
    plan.most_bytes = static_cast<std::uint64_t>(most);
    SqliteHistory history(plan, network_, troubles_);
    EXPECT_EQ(std::filesystem::exists(earlier), fits);
    write_cycles(history, 1, 1400);
    const std::int64_t size =
        Database(path_, Database::Mode::read).whole("PRAGMA page_count") * 4096;  // what is in the WAL too
    if (fits) {
      EXPECT_LT(size, most / 2 + slack);
    } else {
      EXPECT_GT(size, most / 2 + slack);
      EXPECT_LT(size, most + slack);
    }
  }
}

/// What was committed is not lost where it is only the old rows that cannot be removed.
TEST_F(SqliteFile, where_no_old_row_can_go_it_is_a_fault_but_no_row_is_lost) {
  HistoryPlan plan{path_};
  plan.most_days = 1.0;
  SqliteHistory history(plan, network_, troubles_);
  Database(path_, Database::Mode::write)
      .run("CREATE TRIGGER keeps BEFORE DELETE ON cycle BEGIN SELECT RAISE(ABORT, 'kept'); END");
  write_at_once(history, cycles_at(network_, {200'000, 0}));
  EXPECT_TRUE(is_at_fault());
  EXPECT_EQ(history.lost().load(), 0U);
  EXPECT_EQ(table().rows(), 2U);
}

}  // namespace keep_sqlite_aging_test
}  // namespace spindle_twin::firmware
