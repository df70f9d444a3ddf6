#include "firmware/keep/touch_off_history.hpp"

#include <gtest/gtest.h>

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
        "length_output REAL, length_m REAL, tare_um REAL, \"deformation.no\"\"se_um\" REAL)");
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
    Statement row = database.prepare("INSERT INTO cycle VALUES (?, ?, ?, 0, ?, 0, 1e-6, 0, ?)");
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
}

}  // namespace keep_touch_off_history_test
}  // namespace spindle_twin::firmware
