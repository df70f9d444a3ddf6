#include "firmware/keep/sqlite_history.hpp"

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
namespace keep_sqlite_history_test {

TEST_F(SqliteFile, each_start_and_each_gap_begins_a_run_and_rows_are_in_order) {
  {
    SqliteHistory history({path_}, network_, troubles_);
    write_cycles(history, 1, 200);
    write_cycles(history, 300, 310);
  }
  write_run(5);
  ASSERT_EQ(runs().size(), 3U);
  EXPECT_EQ(runs()[0].rows, 200);
  EXPECT_EQ(runs()[1].rows, 11);
  EXPECT_EQ(runs()[2].rows, 5);
  EXPECT_EQ(runs()[0].spindle, "small");
  const rom::CsvTable first = table(runs()[0].id);
  for (std::size_t i = 0; i < first.rows(); ++i) EXPECT_EQ(first.column("sequence")[i], static_cast<double>(i + 1));
  EXPECT_EQ(table().rows(), 5U) << "the last run where none is named";
  EXPECT_FALSE(is_at_fault());
}

TEST_F(SqliteFile, another_network_begins_a_run) {
  change_ = [](Snapshot& snapshot) { snapshot.network_id = snapshot.sequence <= 30 || snapshot.sequence > 70 ? 7 : 8; };
  write_run(100);
  ASSERT_EQ(runs().size(), 3U);
  EXPECT_EQ(runs()[0].rows, 30);
  EXPECT_EQ(runs()[1].rows, 40);
  EXPECT_EQ(table(runs()[2].id).column("sequence").front(), 71.0);
}

TEST_F(SqliteFile, its_columns_are_those_of_the_csv_and_its_numbers_those_of_the_daemon_to_the_bit) {
  std::mt19937 random(3);
  std::vector<double> told;
  change_ = [&](Snapshot& snapshot) {
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    snapshot.signals[0] = 6000.0 * any(random);
    snapshot.deformation_raw_m[0] = 1e-5 * any(random);
    std::vector<double> numbers;
    history_numbers(snapshot, numbers);
    told.insert(told.end(), numbers.begin(), numbers.end());
  };
  write_run(100);
  const rom::CsvTable read = table();
  std::string header;
  for (const std::string& name : read.names) header.append(header.empty() ? "" : ",").append(name);
  EXPECT_EQ(header, history_header(network_));
  for (std::size_t i = 0; i < read.rows(); ++i) {
    for (std::size_t c = 0; c < read.names.size(); ++c) {
      const double expected = told[i * read.names.size() + c];
      const double got = read.columns[c][i];
      if (std::isfinite(expected)) {
        EXPECT_EQ(std::bit_cast<std::uint64_t>(got + 0.0), std::bit_cast<std::uint64_t>(expected + 0.0))
            << read.names[c];
      } else {
        EXPECT_TRUE(std::isnan(got)) << read.names[c];
      }
    }
  }
}

TEST_F(SqliteFile, is_read_while_it_is_written) {
  SqliteHistory history({path_}, network_, troubles_);
  write_cycles(history, 1, 10);
  EXPECT_EQ(table().rows(), 10U);
  write_cycles(history, 11, 20);
  EXPECT_EQ(table().rows(), 20U);
}

TEST_F(SqliteFile, one_that_is_removed_while_it_is_written_is_begun_anew_and_said) {
  SqliteHistory history({path_}, network_, troubles_);
  write_cycles(history, 1, 10);
  std::filesystem::remove(path_);
  write_cycles(history, 11, 12);
  write_cycles(history, 13, 20);
  EXPECT_EQ(table().rows(), 10U);
  EXPECT_FALSE(is_at_fault());
}

TEST_F(SqliteFile, one_of_other_columns_and_a_damaged_one_are_put_aside) {
  write_run(3);
  network_.key_points[0].name = "renamed";
  write_run(4);
  EXPECT_EQ(table().rows(), 4U);
  ASSERT_EQ(earlier_histories(path_), std::vector<std::string>{folder_.file("history.000001.sqlite")});
  EXPECT_EQ(SqliteHistoryReader(folder_.file("history.000001.sqlite")).table(std::nullopt).rows(), 3U);
  std::ofstream(path_, std::ios::trunc) << std::string(10000, 'x');
  {
    SqliteHistory history({path_}, network_, troubles_);
    write_cycles(history, 1, 2);
    EXPECT_TRUE(is_at_fault());
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    write_cycles(history, 3, 7);
  }
  EXPECT_FALSE(is_at_fault());
  EXPECT_EQ(table().rows(), 5U);
  EXPECT_EQ(earlier_histories(path_).size(), 2U);
}

/// A process's limit of file sizes stands for a full disk.
TEST_F(SqliteFile, on_a_full_disk_rows_are_lost_and_counted_what_is_there_stays_and_it_goes_on_afterwards) {
  SqliteHistory history({path_}, network_, troubles_);
  write_cycles(history, 1, 50);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{std::filesystem::file_size(path_ + "-wal") + 2000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  write_cycles(history, 51, 250);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  EXPECT_TRUE(is_at_fault());
  const std::uint64_t lost = history.lost().load();
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(troubles_.history_rows_lost.load(), lost);
  std::size_t rows = 0;
  for (const HistoryRun& run : runs()) rows += static_cast<std::size_t>(run.rows);
  EXPECT_EQ(rows + lost, 250U);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_cycles(history, 251, 260);
  EXPECT_FALSE(is_at_fault());
  EXPECT_EQ(table().rows(), 10U);
  EXPECT_EQ(table().column("sequence")[0], 251.0);
}

TEST_F(SqliteFile, a_folder_that_is_not_there_is_a_fault_and_not_the_end_and_it_is_tried_again) {
  path_ = folder_.file("away/history.sqlite");
  SqliteHistory history({path_}, network_, troubles_);
  EXPECT_TRUE(is_at_fault());
  write_cycles(history, 1, 5);
  EXPECT_EQ(troubles_.history_rows_lost.load(), 5U);
  std::filesystem::create_directory(folder_.file("away"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_cycles(history, 6, 8);
  EXPECT_FALSE(is_at_fault());
  EXPECT_EQ(table().rows(), 3U);
}

TEST_F(SqliteFile, each_row_has_the_time_of_its_cycle_and_a_run_that_of_its_first) {
  SqliteHistory history({path_}, network_, troubles_);
  write_at_once(history, cycles_at(network_, {50'000, 49'990, 49'000}));
  ASSERT_EQ(runs().size(), 1U);
  EXPECT_NEAR(runs()[0].first_unix_s, unix_now_s() - 50'000.0, 600.0);
  EXPECT_NEAR(runs()[0].last_unix_s - runs()[0].first_unix_s, 1000.0, 1e-3);
  Database database(path_, Database::Mode::read);
  Statement began = database.prepare("SELECT began_unix_s, id FROM run");
  ASSERT_TRUE(began.step());
  EXPECT_EQ(began.number(0), runs()[0].first_unix_s);
  EXPECT_EQ(database.whole("SELECT count(*) FROM cycle WHERE run = 1 AND id BETWEEN 1 AND 3"), 3);
  write_at_once(history, cycles_at(network_, {0}));
  EXPECT_EQ(table().rows(), 1U) << "a single row is written too";
}

TEST_F(SqliteFile, one_of_another_program_or_version_is_put_aside_and_left_as_it_is) {
  for (const char* other : {"PRAGMA application_id = 7", "PRAGMA user_version = 2"}) {
    write_run(3);
    const std::size_t before = earlier_histories(path_).size();
    Database(path_, Database::Mode::write).run(other);
    write_run(2);
    EXPECT_EQ(table().rows(), 2U) << other;
    ASSERT_EQ(earlier_histories(path_).size(), before + 1) << other;
    Database aside(earlier_histories(path_).back(), Database::Mode::read);
    EXPECT_EQ(aside.whole("SELECT count(*) FROM cycle"), before == 0 ? 3 : 5);
    EXPECT_EQ(Database(path_, Database::Mode::read).whole("PRAGMA user_version"), 1);
    EXPECT_EQ(Database(path_, Database::Mode::read).whole("PRAGMA application_id"), 0x53545748);
    EXPECT_FALSE(is_at_fault());
  }
}

TEST_F(SqliteFile, what_is_no_history_is_one_clear_error) {
  EXPECT_EQ(error_of(folder_.file("missing.sqlite")).find(folder_.file("missing.sqlite") + ": cannot be read"), 0U);
  EXPECT_NE(error_of(folder_.write("text.sqlite", "no database at all")).find("cannot be read as a history"),
            std::string::npos);
  { Database(folder_.file("other.sqlite"), Database::Mode::write).run("CREATE TABLE run (a)"); }
  EXPECT_NE(error_of(folder_.file("other.sqlite")).find("is no history of spindle-twind"), std::string::npos);
  { const SqliteHistory empty({path_}, network_, troubles_); }
  EXPECT_NE(error_of(path_).find("this history has no row yet"), std::string::npos);
  write_run(2);
  EXPECT_THROW(table(77), rom::InputError);
  { Database(path_, Database::Mode::write).run("PRAGMA user_version = 9"); }
  EXPECT_NE(error_of(path_).find("user_version: is 9; this program reads 1"), std::string::npos);
}

TEST_F(SqliteFile, a_row_that_is_gone_from_the_middle_is_damage_and_the_oldest_may_go_while_it_is_read) {
  write_run(40);
  const SqliteHistoryReader reader(path_);
  ASSERT_EQ(reader.runs().front().rows, 40);
  Database(path_, Database::Mode::write).run("DELETE FROM cycle WHERE id <= 5");
  EXPECT_EQ(reader.table(std::nullopt).rows(), 35U);
  Database(path_, Database::Mode::write).run("DELETE FROM cycle WHERE id = 20");
  try {
    reader.table(std::nullopt);
    FAIL() << "read with a hole";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()), path_ + ": run: 1 has 34 rows, 35 by their numbers: the file is damaged");
  }
}

/// What a broken disk leaves ends in an error or in rows, never in a crash: 300 files cut or changed at random.
TEST_F(SqliteFile, a_file_that_is_cut_or_scrambled_never_ends_in_more_than_an_error) {
  write_run(40);
  std::ifstream file(path_, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::mt19937 random(5);
  int refused = 0, read = 0;
  for (int n = 0; n < 300; ++n) {
    std::string broken = whole;
    if (n % 3 == 0) broken.resize(random() % whole.size());
    for (unsigned change = 0; change <= random() % 40 && !broken.empty(); ++change) {
      broken[random() % broken.size()] = static_cast<char>(random());
    }
    const std::string path = folder_.write("broken.sqlite", broken);
    try {
      SqliteHistoryReader(path).table(std::nullopt);
      ++read;
    } catch (const rom::InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(read, 0);
}

}  // namespace keep_sqlite_history_test
}  // namespace spindle_twin::firmware
