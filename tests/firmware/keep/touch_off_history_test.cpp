#include "firmware/keep/touch_off_history.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "rom/read/input_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_touch_off_history_test {

bool always() { return true; }

class TouchOffsOf : public ::testing::Test {
 protected:
  TouchOffsOf() { make(); }
  void make() const {
    Database database(path_, Database::Mode::write);
    database.run(
        "PRAGMA journal_mode = WAL; PRAGMA user_version = 1;"
        "CREATE TABLE run (id INTEGER PRIMARY KEY, began_unix_s REAL, spindle TEXT);"
        "CREATE TABLE cycle (id INTEGER PRIMARY KEY, run INTEGER, unix_s REAL, tare_count REAL, length_orders REAL, "
        "length_output REAL, length_m REAL, length_sd_m REAL, tare_um REAL, \"deformation.no\"\"se_um\" REAL)");
  }
  /// A run of rows a second from each other, the nose published as 0.001 um times its number; a touch-off of 1e-6 m in
  /// each row for which `is_touched`.
  void write(std::int64_t rows, const std::function<bool(std::int64_t)>& is_touched) {
    Database database(path_, Database::Mode::write);
    const std::int64_t first = 1 + database.whole("SELECT max(id) FROM cycle");
    database.run("BEGIN");
    Statement run = database.prepare("INSERT INTO run VALUES (?, 0, 'a')");
    run.bind(0, first);
    run.run();
    Statement row = database.prepare("INSERT INTO cycle VALUES (?, ?, ?, 0, ?, 0, 1e-6, 1e-6, 0, ?)");
    double orders = 0.0;
    for (std::int64_t n = 0; n < rows; ++n) {
      orders += is_touched(n) ? 1.0 : 0.0;
      row.bind(0, first + n);
      row.bind(1, first);
      row.bind(2, static_cast<double>(first + n));
      row.bind(3, orders);
      row.bind(4, 0.001 * static_cast<double>(first + n));
      row.run();
    }
    database.run("COMMIT");
  }
  void remove_to(std::int64_t id) {
    Database(path_, Database::Mode::write).run("DELETE FROM cycle WHERE id <= " + std::to_string(id));
  }
  std::vector<double> times() {
    const FoundTouchOffs found = history_.read(always);
    EXPECT_TRUE(found.is_whole);
    std::vector<double> times;
    for (const correction::GrowthReading& reading : found.outputs.at(0).readings) times.push_back(reading.unix_s);
    return times;
  }

  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("history.sqlite");
  TouchOffHistory history_{path_, {"no\"se"}};
};

TEST_F(TouchOffsOf, all_are_found_with_what_was_published_in_the_row_before) {
  write(1000, [](std::int64_t n) { return n == 1 || n == 500 || n == 501 || n == 999; });
  write(1, [](std::int64_t) { return false; });
  write(64, [](std::int64_t n) { return n == 30; });
  EXPECT_EQ(times(), (std::vector<double>{2, 501, 502, 1000, 1032}));
  const FoundTouchOffs found = history_.read(always);
  EXPECT_EQ(found.outputs.at(0).output, "no\"se");
  EXPECT_EQ(found.outputs.at(0).stretches, 3U);
  EXPECT_NEAR(found.outputs.at(0).readings.at(1).predicted_m, 0.5e-6, 1e-15);
  EXPECT_EQ(found.outputs.at(0).readings.at(1).measured_m, 1e-6);
}

TEST_F(TouchOffsOf, a_touch_off_costs_some_twenty_rows_and_who_asks_again_pays_for_the_new_ones) {
  int asked = 0;
  const auto count = [&] { return ++asked > 0; };
  write(100'000, [](std::int64_t n) { return n % 20'000 == 7'000; });
  EXPECT_EQ(history_.read(count).outputs.at(0).readings.size(), 5U);
  EXPECT_LE(asked, 5 * 2 * 17 / 16 + 1);
  asked = 0;
  EXPECT_EQ(history_.read(count).outputs.at(0).readings.size(), 5U);
  EXPECT_EQ(asked, 0);
  write(100, [](std::int64_t n) { return n == 50; });
  EXPECT_EQ(history_.read(count).outputs.at(0).readings.size(), 6U);
  EXPECT_LE(asked, 1);
}

TEST_F(TouchOffsOf, it_may_rest_at_each_sixteenth_row) {
  const std::string numbers =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 31) INSERT INTO ";
  Database(path_, Database::Mode::write)
      .run(numbers + "run SELECT i, 0, 'a' FROM n;" + numbers + "cycle SELECT i, i, i, 0, 0, 0, 0, 0, 0, 0 FROM n");
  for (const int runs : {31, 32, 33}) {
    if (runs > 31) write(1, [](std::int64_t) { return false; });
    int asked = 0;
    const auto count = [&] { return ++asked > 0; };
    EXPECT_EQ(TouchOffHistory(path_, {"no\"se"}).read(count).outputs.at(0).stretches, static_cast<std::size_t>(runs));
    EXPECT_EQ(asked, runs / 16) << "a run of one row costs one";
  }
}

TEST_F(TouchOffsOf, what_was_not_read_in_time_comes_with_the_next_readings) {
  write(3000, [](std::int64_t n) { return n % 300 == 150; });
  std::size_t before = 0;
  for (int readings = 0;; ++readings) {
    ASSERT_LT(readings, 100);
    int left = 1;
    const FoundTouchOffs found = history_.read([&] { return --left >= 0; });
    EXPECT_GE(found.outputs.at(0).readings.size(), before);
    before = found.outputs.at(0).readings.size();
    if (found.is_whole) break;
  }
  EXPECT_EQ(before, 10U);
}

TEST_F(TouchOffsOf, what_the_daemon_lets_go_counts_no_more_and_its_rest_makes_no_touch_off_of_its_own) {
  write(100, [](std::int64_t n) { return n == 20 || n == 60; });
  write(100, [](std::int64_t n) { return n == 50; });
  EXPECT_EQ(times(), (std::vector<double>{21, 61, 151}));
  remove_to(40);
  EXPECT_EQ(times(), (std::vector<double>{61, 151}));
  remove_to(61);
  EXPECT_EQ(times(), (std::vector<double>{151}));
  remove_to(100);
  EXPECT_EQ(history_.read(always).outputs.at(0).stretches, 1U) << "of the first run no row is left";
  remove_to(120);
  EXPECT_EQ(times(), (std::vector<double>{151}));
  EXPECT_EQ(history_.read(always).outputs.at(0).stretches, 1U);
  remove_to(200);
  EXPECT_TRUE(times().empty());
}

TEST_F(TouchOffsOf, of_a_file_that_was_put_aside_nothing_is_left) {
  write(100, [](std::int64_t n) { return n == 20 || n == 60; });
  EXPECT_EQ(times(), (std::vector<double>{21, 61}));
  for (const char* end : {"", "-wal", "-shm"}) {
    const std::string part = path_ + end;
    if (std::filesystem::exists(part)) std::filesystem::rename(part, part + ".1");
  }
  make();
  write(200, [](std::int64_t n) { return n == 40; });
  EXPECT_EQ(times(), (std::vector<double>{41}));
}

TEST_F(TouchOffsOf, of_a_control_that_hands_over_a_length_each_cycle_the_newest_are_kept) {
  write(25'000, [](std::int64_t) { return true; });
  write(10, [](std::int64_t n) { return n == 5; });
  const std::vector<double> found = times();
  EXPECT_EQ(found.size(), TouchOffHistory::most_changes + 1);
  EXPECT_EQ(found.front(), 25'000.0 - TouchOffHistory::most_changes + 1);
  EXPECT_EQ(found.back(), 25'006.0);
}

TEST_F(TouchOffsOf, what_is_no_history_or_a_newer_one_is_refused_by_its_name) {
  EXPECT_THROW(TouchOffHistory("/nowhere/history.sqlite", {}).read(always), rom::InputError);
  write(3, [](std::int64_t) { return true; });
  EXPECT_THROW(TouchOffHistory(path_, {"tail"}).read(always), rom::InputError);
  Database(path_, Database::Mode::write).run("PRAGMA user_version = 2");
  EXPECT_THROW(history_.read(always), rom::InputError);
  try {
    history_.read(always);
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()), path_ + ": user_version: is 2; this program reads 1");
  }
  std::filesystem::remove(path_);
  try {
    history_.read(always);
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()).find(path_ + ": cannot be read as a history in SQLite: "), 0U) << error.what();
  }
}

/// Rows by hand, of two outputs.
class TwoOutputs : public ::testing::Test {
 protected:
  struct Told {
    double tares, orders, of_output, length_m, tare_um, nose_um, rear_um;
  };
  void write(std::int64_t run, const std::vector<Told>& rows) {
    Database database(path_, Database::Mode::write);
    if (database.whole("SELECT count(*) FROM sqlite_schema") == 0) {
      database.run(
          "CREATE TABLE run (id INTEGER PRIMARY KEY);"
          "CREATE TABLE cycle (id INTEGER PRIMARY KEY, unix_s REAL, tare_count REAL, length_orders REAL, "
          "length_output REAL, length_m REAL, length_sd_m REAL, tare_um REAL, \"deformation.nose_um\" REAL, "
          "\"deformation.rear_um\" REAL)");
    }
    database.run("PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN");
    Statement begin = database.prepare("INSERT INTO run VALUES (?)");
    begin.bind(0, run);
    begin.run();
    Statement row = database.prepare("INSERT INTO cycle VALUES (?, ?, ?, ?, ?, ?, 1e-6, ?, ?, ?)");
    for (std::size_t n = 0; n < rows.size(); ++n) {
      const std::int64_t id = run + static_cast<std::int64_t>(n);
      const Told& of = rows[n];
      const std::array<double, 8> numbers{1000.0 + static_cast<double>(id),
                                          of.tares,
                                          of.orders,
                                          of.of_output,
                                          of.length_m,
                                          of.tare_um,
                                          of.nose_um,
                                          of.rear_um};
      row.bind(0, id);
      for (std::size_t i = 0; i < numbers.size(); ++i) row.bind(static_cast<int>(i) + 1, numbers[i]);
      row.run();
    }
    database.run("COMMIT");
  }
  FoundTouchOffs found() { return TouchOffHistory(path_, {"nose", "rear"}).read(always); }

  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("history.sqlite");
};

TEST_F(TwoOutputs, each_has_the_lengths_that_were_handed_over_for_it_and_only_the_noses_count_from_the_tare) {
  write(1, {{0, 0, 0, 0.0, 2.0, 5.0, 11.0},
            {0, 1, 0, 4e-6, 2.0, 6.0, 12.0},
            {0, 1, 0, 4e-6, 2.0, 7.0, 13.0},
            {0, 2, 1, 9e-6, 2.0, 8.0, 14.0},
            {1, 2, 1, 9e-6, 3.0, 9.0, 15.0},
            {1, 3, 1, 8e-6, 3.0, 9.5, 16.0},
            {2, 4, 0, 1e-6, 1.0, 9.5, 16.0}});
  const FoundTouchOffs told = found();
  EXPECT_TRUE(told.is_whole);
  ASSERT_EQ(told.outputs.size(), 2U);
  EXPECT_EQ(told.outputs[0].output, "nose");
  EXPECT_EQ(told.outputs[1].output, "rear");
  for (const OutputTouchOffs& output : told.outputs) EXPECT_EQ(output.stretches, 3U) << "from the start and two tares";
  ASSERT_EQ(told.outputs[0].readings.size(), 1U);
  const correction::GrowthReading& nose = told.outputs[0].readings[0];
  EXPECT_EQ(nose.unix_s, 1002.0);
  EXPECT_EQ(nose.stretch, 0U);
  EXPECT_EQ(nose.measured_m, 4e-6);
  EXPECT_NEAR(nose.predicted_m, 3e-6, 1e-15);
  ASSERT_EQ(told.outputs[1].readings.size(), 2U);
  const std::vector<correction::GrowthReading>& rear = told.outputs[1].readings;
  EXPECT_EQ(rear[0].unix_s, 1004.0);
  EXPECT_EQ(rear[0].measured_m, 9e-6);
  EXPECT_NEAR(rear[0].predicted_m, 13e-6, 1e-15);
  EXPECT_EQ(rear[1].unix_s, 1006.0);
  EXPECT_EQ(rear[1].stretch, 1U);
  EXPECT_NEAR(rear[1].predicted_m, 15e-6, 1e-15);
}

/// A change in any two rows behind each other is found, in a run of any length.
TEST_F(TwoOutputs, wherever_a_tare_and_a_length_stand_in_a_run_both_are_found) {
  std::int64_t run = 1;
  std::size_t lengths = 0, runs = 0, tares = 0;
  for (int rows = 1; rows <= 5; ++rows) {
    for (int length = 0; length < rows; ++length) {
      for (int tare = 0; tare < rows; ++tare) {
        std::vector<Told> told;
        for (int n = 0; n < rows; ++n)
          told.push_back({n >= tare ? 1.0 : 0.0, n >= length ? 1.0 : 0.0, 0, 1e-6, 0, 1, 1});
        write(run, told);
        run += rows;
        ++runs;
        tares += tare > 0 ? 1 : 0;
        lengths += length > 0 && length != tare ? 1 : 0;
      }
    }
  }
  const FoundTouchOffs told = found();
  EXPECT_EQ(told.outputs[0].readings.size(), lengths);
  EXPECT_EQ(told.outputs[0].stretches, runs + tares);
  EXPECT_TRUE(told.outputs[1].readings.empty());
}

TEST_F(TwoOutputs, an_empty_history_and_a_run_that_has_no_row_yet_have_none) {
  write(1, {});
  EXPECT_TRUE(found().is_whole);
  EXPECT_EQ(found().outputs[0].stretches, 0U);
  Database(path_, Database::Mode::write).run("DELETE FROM run");
  write(1, {{0, 0, 0, 0.0, 0.0, 1.0, 1.0}, {0, 1, 0, 1e-6, 0.0, 1.0, 1.0}});
  write(3, {});
  EXPECT_EQ(found().outputs[0].readings.size(), 1U);
  EXPECT_EQ(found().outputs[0].stretches, 1U);
}

}  // namespace keep_touch_off_history_test
}  // namespace spindle_twin::firmware
