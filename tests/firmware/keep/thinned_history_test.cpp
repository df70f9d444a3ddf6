#include "firmware/keep/thinned_history.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "firmware/cycle/snapshot.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_thinned_history_test {

constexpr double now_s = 1'800'000'000.0;  ///< where a span of 1, 8 and 24 hours begins
bool always() { return true; }

class Thinned : public ::testing::Test {
 protected:
  /// A row each second from `from_s` to before `to_s`; `value` gives its number, NaN none.
  void write(std::int64_t run, double from_s, double to_s, const std::function<double(double)>& value) {
    Database database(path_, Database::Mode::write);
    database.run(
        "PRAGMA journal_mode = WAL; PRAGMA user_version = 1;"
        "CREATE TABLE IF NOT EXISTS cycle (id INTEGER PRIMARY KEY, run INTEGER, unix_s REAL, \"a \"\"b\"\"\" REAL);"
        "CREATE INDEX IF NOT EXISTS cycle_by_time ON cycle (unix_s); BEGIN");
    Statement insert = database.prepare("INSERT INTO cycle (run, unix_s, \"a \"\"b\"\"\") VALUES (?, ?, ?)");
    for (double at_s = from_s; at_s < to_s; at_s += 1.0) {
      insert.bind(0, run);
      insert.bind(1, at_s);
      insert.bind(2, value(at_s));
      insert.run();
    }
    database.run("COMMIT");
  }
  ThinnedHours read(int hours = 1, double at_s = now_s, const std::function<bool()>& go_on = always) {
    return history_.read(hours, at_s, go_on);
  }
  std::string error_of(const std::string& column = "a \"b\"") {
    try {
      ThinnedHistory(path_, {column}).read(1, now_s, always);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("history.sqlite");
  ThinnedHistory history_{path_, {"a \"b\""}};
};

TEST_F(Thinned, of_a_ramp_each_span_has_its_ends_and_their_middle) {
  write(1, now_s - 3600.0, now_s, [](double at_s) { return at_s - now_s; });
  const ThinnedHours hour = read();
  EXPECT_EQ(hour.span_s, 6.0);
  EXPECT_TRUE(hour.is_whole);
  // The present span has no row yet, and the one that begins an hour before it is no longer among the 600.
  ASSERT_EQ(hour.unix_s.size(), 599U);
  ASSERT_EQ(hour.columns.size(), 1U);
  EXPECT_EQ(hour.columns[0].name, "a \"b\"");
  for (std::size_t i = 0; i < hour.unix_s.size(); ++i) {
    const double first = -3594.0 + 6.0 * static_cast<double>(i);
    EXPECT_EQ(hour.unix_s[i], now_s + first + 2.5);
    EXPECT_EQ(hour.columns[0].least[i], static_cast<float>(first));
    EXPECT_EQ(hour.columns[0].mean[i], static_cast<float>(first + 2.5));
    EXPECT_EQ(hour.columns[0].greatest[i], static_cast<float>(first + 5.0));
  }
}

TEST_F(Thinned, a_week_is_as_many_spans_and_holds_a_peak_of_one_row) {
  const double peak_s = now_s - 5.0 * 86400.0;
  write(1, peak_s - 1000.0, peak_s + 1000.0, [&](double at_s) { return at_s == peak_s ? 7.0 : 0.0; });
  const ThinnedHours week = read(168);
  EXPECT_EQ(week.span_s, 1008.0);
  EXPECT_LE(week.unix_s.size(), 4U);
  EXPECT_EQ(*std::max_element(week.columns[0].greatest.begin(), week.columns[0].greatest.end()), 7.0F);
  EXPECT_TRUE(read(1).unix_s.empty());
}

TEST_F(Thinned, between_runs_is_a_moment_without_values_and_within_one_none) {
  write(1, now_s - 1200.0, now_s - 900.0, [](double) { return 1.0; });
  write(7, now_s - 600.0, now_s - 300.0, [](double) { return 2.0; });
  // Rows rarer than spans are no gaps.
  write(7, now_s - 240.0, now_s - 239.0, [](double) { return 3.0; });
  const ThinnedHours hour = read();
  ASSERT_EQ(hour.unix_s.size(), 50U + 1U + 50U + 1U);
  const std::vector<float>& mean = hour.columns[0].mean;
  for (std::size_t i = 0; i < mean.size(); ++i) EXPECT_EQ(std::isnan(mean[i]), i == 50) << i;
  EXPECT_TRUE(std::isnan(hour.columns[0].least[50]));
  EXPECT_EQ(hour.unix_s[50], now_s - 750.0 - 0.5);
  EXPECT_TRUE(std::is_sorted(hour.unix_s.begin(), hour.unix_s.end()));
}

TEST_F(Thinned, where_a_value_is_missing_the_others_of_its_span_count) {
  write(1, now_s - 60.0, now_s, [](double at_s) { return std::fmod(at_s, 6.0) == 2.0 ? 5.0 : std::nan(""); });
  write(1, now_s - 66.0, now_s - 60.0, [](double) { return std::nan(""); });
  const ThinnedColumn column = read().columns[0];
  ASSERT_EQ(column.mean.size(), 11U);
  EXPECT_TRUE(std::isnan(column.mean[0]));
  for (std::size_t i = 1; i < 11; ++i) {
    EXPECT_EQ(column.least[i], 5.0F);
    EXPECT_EQ(column.mean[i], 5.0F);
    EXPECT_EQ(column.greatest[i], 5.0F);
  }
}

TEST_F(Thinned, values_below_zero_that_fall_and_single_ones_have_their_own_ends) {
  write(1, now_s - 60.0, now_s - 30.0, [](double at_s) { return now_s - 100.0 - at_s; });
  write(1, now_s - 30.0, now_s, [](double at_s) { return std::fmod(at_s, 6.0) == 4.0 ? -2.0 : std::nan(""); });
  const ThinnedHours hour = read();
  const ThinnedColumn& column = hour.columns[0];
  ASSERT_EQ(column.mean.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    const float first = i < 5 ? -40.0F - 6.0F * static_cast<float>(i) : -2.0F;
    EXPECT_EQ(column.greatest[i], first) << i;
    EXPECT_EQ(column.mean[i], i < 5 ? first - 2.5F : first) << i;
    EXPECT_EQ(column.least[i], i < 5 ? first - 5.0F : first) << i;
  }
}

TEST_F(Thinned, each_of_several_columns_has_its_own_values_and_a_gap_is_one_in_all) {
  {
    Database database(path_, Database::Mode::write);
    database.run(
        "CREATE TABLE cycle (id INTEGER PRIMARY KEY, run INTEGER, unix_s REAL, a REAL, b REAL, c REAL);"
        "INSERT INTO cycle VALUES (1, 1, 1799999980, 1, 10, NULL), (2, 1, 1799999981, 3, 30, -5),"
        "(3, 3, 1799999990, 7, 70, -9)");
  }
  const ThinnedHours hour = ThinnedHistory(path_, {"a", "b", "c"}).read(1, now_s, always);
  ASSERT_EQ(hour.unix_s.size(), 3U);
  ASSERT_EQ(hour.columns.size(), 3U);
  const auto told = [&](std::size_t column, std::size_t moment) {
    const ThinnedColumn& of = hour.columns[column];
    return std::array<float, 3>{of.least[moment], of.mean[moment], of.greatest[moment]};
  };
  EXPECT_EQ(told(0, 0), (std::array<float, 3>{1.0F, 2.0F, 3.0F}));
  EXPECT_EQ(told(1, 0), (std::array<float, 3>{10.0F, 20.0F, 30.0F}));
  EXPECT_EQ(told(2, 0), (std::array<float, 3>{-5.0F, -5.0F, -5.0F}));
  EXPECT_EQ(told(0, 2), (std::array<float, 3>{7.0F, 7.0F, 7.0F}));
  EXPECT_EQ(told(1, 2), (std::array<float, 3>{70.0F, 70.0F, 70.0F}));
  EXPECT_EQ(told(2, 2), (std::array<float, 3>{-9.0F, -9.0F, -9.0F}));
  for (std::size_t column = 0; column < 3; ++column) {
    for (const float value : told(column, 1)) EXPECT_TRUE(std::isnan(value)) << column;
  }
}

TEST_F(Thinned, a_span_in_which_a_run_ends_and_the_next_begins_parts_neither) {
  write(1, now_s - 60.0, now_s - 21.0, [](double) { return 1.0; });
  write(5, now_s - 21.0, now_s, [](double) { return 2.0; });
  const ThinnedHours hour = read();
  EXPECT_EQ(hour.unix_s.size(), 10U);
  for (const float mean : hour.columns[0].mean) EXPECT_FALSE(std::isnan(mean));
}

TEST_F(Thinned, it_may_rest_before_each_span_and_at_each_hundredth_row) {
  int asked = 0;
  const std::function<bool()> count = [&] { return ++asked > 0; };
  write(1, now_s - 1288.0, now_s, [](double) { return 1.0; });  // a thousand in one span
  const ThinnedHours week = read(168, now_s, count);
  EXPECT_TRUE(week.is_whole);
  int rests = ThinnedHistory::most_spans;
  for (std::int64_t second = 1'799'998'712, rows = 0; second < 1'800'000'000; ++second) {
    rows = second % 1008 == 0 ? 1 : rows + 1;
    if (rows % 100 == 0) ++rests;
  }
  EXPECT_EQ(asked, rests);
}

TEST_F(Thinned, who_asks_again_gets_what_came_meanwhile_and_is_asked_for_new_spans_only) {
  write(1, now_s - 1800.0, now_s, [](double) { return 1.0; });
  read();
  write(1, now_s, now_s + 30.0, [](double) { return 2.0; });
  int spans = 0;
  const ThinnedHours later = read(1, now_s + 30.0, [&] { return ++spans > 0; });
  EXPECT_EQ(later.columns[0].mean.back(), 2.0F);
  EXPECT_EQ(later.unix_s.size(), 305U);
  // 60 s may still get rows, 30 s are new, and the present span.
  EXPECT_EQ(spans, 16);
}

TEST_F(Thinned, a_reading_that_is_ended_has_the_newest_and_the_next_goes_on_to_the_same_whole) {
  write(1, now_s - 3600.0, now_s, [](double at_s) { return std::sin(at_s); });
  const ThinnedHours whole = ThinnedHistory(path_, {"a \"b\""}).read(1, now_s, always);
  int left = 100;
  const std::function<bool()> for_a_while = [&left] { return left-- > 0; };
  const ThinnedHours part = read(1, now_s, for_a_while);
  EXPECT_FALSE(part.is_whole);
  EXPECT_EQ(part.unix_s.size(), 99U);
  EXPECT_EQ(part.unix_s.back(), whole.unix_s.back());
  for (int n = 0; n < 10 && !read(1, now_s, for_a_while).is_whole; ++n) left = 100;
  const ThinnedHours last = read();
  EXPECT_EQ(last.unix_s, whole.unix_s);
  EXPECT_EQ(last.columns[0].mean, whole.columns[0].mean);
}

TEST_F(Thinned, a_clock_that_is_set_back_shows_no_row_of_its_future) {
  write(1, now_s - 3600.0, now_s, [](double) { return 1.0; });
  read();
  const double before_s = now_s - 1800.0;
  write(2, before_s - 6.0, before_s, [](double) { return 9.0; });
  const ThinnedHours again = read(1, before_s);
  EXPECT_LT(again.unix_s.back(), before_s + 6.0);
  EXPECT_EQ(*std::max_element(again.columns[0].greatest.begin(), again.columns[0].greatest.end()), 9.0F);
}

TEST_F(Thinned, what_a_daemon_writes_is_read_while_it_writes) {
  const rom::Network network = tests::small_network();
  Troubles troubles;
  SqliteHistory writer({path_}, network, troubles);
  std::atomic<bool> stop{false};
  Snapshot snapshot;
  snapshot.nose_m = 3e-6;
  snapshot.time_ns = MonotonicClock().now_ns();
  for (snapshot.sequence = 1; snapshot.sequence <= 5; ++snapshot.sequence) writer.ring().push(snapshot);
  ThinnedHistory history(path_, {"nose_um"});
  EXPECT_TRUE(history.read(1, unix_now_s(), always).unix_s.empty()) << "no row yet is no error";
  std::thread thread([&] { writer.run(stop); });
  stop.store(true);
  thread.join();
  const ThinnedHours read = history.read(1, unix_now_s() + 1.0, always);
  ASSERT_EQ(read.unix_s.size(), 1U);
  EXPECT_FLOAT_EQ(read.columns[0].mean[0], 3.0F);
  EXPECT_EQ(troubles.faults() & bits(Fault::history_lost), 0U);
}

TEST_F(Thinned, a_reader_in_the_middle_of_a_span_holds_up_no_writer) {
  write(1, now_s - 3600.0, now_s, [](double) { return 1.0; });
  int asked = 0;
  read(168, now_s, [&] {
    if (++asked == 3) write(1, now_s, now_s + 5.0, [](double) { return 2.0; });
    return true;
  });
  EXPECT_GE(asked, 3);
  EXPECT_EQ(read(1, now_s + 5.0).columns[0].greatest.back(), 2.0F);
}

TEST_F(Thinned, what_is_no_history_is_one_clear_error) {
  EXPECT_EQ(error_of(), path_ + ": cannot be read as a history in SQLite: unable to open database file");
  folder_.write("history.sqlite", "");
  EXPECT_NE(error_of().find("no such table: cycle"), std::string::npos) << error_of();
  { Database(path_, Database::Mode::write).run("CREATE TABLE cycle (unix_s REAL, run INTEGER, other REAL)"); }
  EXPECT_NE(error_of().find("no such column"), std::string::npos) << error_of();
  EXPECT_EQ(error_of("other"), "no error");
  { Database(path_, Database::Mode::write).run("PRAGMA user_version = 2"); }
  EXPECT_EQ(error_of("other"), path_ + ": user_version: is 2; this program reads 1");
  folder_.write("history.sqlite", std::string(10000, 'x'));
  EXPECT_NE(error_of().find("file is not a database"), std::string::npos) << error_of();
}

/// What a broken disk leaves ends in an error or in values, never in a crash.
TEST_F(Thinned, a_file_that_is_cut_or_scrambled_never_ends_in_more_than_an_error) {
  write(1, now_s - 300.0, now_s, [](double at_s) { return at_s; });
  { Database(path_, Database::Mode::write).run("PRAGMA journal_mode = DELETE"); }
  std::ifstream file(path_, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::mt19937 random(5);
  for (int n = 0; n < 200; ++n) {
    std::string broken = whole;
    if (n % 3 == 0) broken.resize(random() % whole.size());
    for (unsigned change = 0; change <= random() % 40 && !broken.empty(); ++change) {
      broken[random() % broken.size()] = static_cast<char>(random());
    }
    folder_.write("history.sqlite", broken);
    const std::string error = error_of();
    EXPECT_TRUE(error == "no error" || error.starts_with(path_ + ": ")) << error;
  }
}

}  // namespace keep_thinned_history_test
}  // namespace spindle_twin::firmware
