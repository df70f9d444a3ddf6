#include "host_tools/evaluate/growth_reading.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "firmware/cycle/publish.hpp"
#include "firmware/keep/history_row.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "firmware/keep/touch_off_history.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools {
namespace growth_reading_test {

constexpr double um = 1e-6;

template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "no error";
}

/// An hour in steps of a minute: the nose is published to grow by 0.1 um each; touch-offs say what `touch` wants.
class Hour : public ::testing::Test {
 protected:
  Hour() {
    network_.deformations = {network_.deformations[0], network_.deformations[0]};
    network_.deformations[1].name = "flange";
    for (int minute = 0; minute < 60; ++minute) rows_.push_back(row(minute));
  }

  firmware::Snapshot row(int minute) const {
    firmware::Snapshot snapshot = firmware::first_snapshot(network_);
    snapshot.sequence = static_cast<std::uint64_t>(minute) + 1;
    snapshot.model_time_s = 60.0 * minute;
    snapshot.clock_ns = 60'000'000'000 * minute;
    snapshot.time_ns = started_ns_ + snapshot.clock_ns;
    snapshot.deformation_m[0] = 0.1 * um * minute;
    snapshot.deformation_m[1] = -0.3 * um * minute;
    return snapshot;
  }
  /// From this minute on the PLC has handed over one length more.
  void touch(int minute, double length_m, std::uint32_t output = 0) {
    for (std::size_t n = static_cast<std::size_t>(minute); n < rows_.size(); ++n) {
      ++rows_[n].displacement_orders;
      rows_[n].displacement.value_m = length_m;
      rows_[n].displacement.deviation_m = 1e-6;
      rows_[n].displacement.output = output;
      rows_[n].deformation_m[0] += 0.05 * um;  // what the estimator makes of it
    }
  }
  std::string csv() const {
    std::string text = firmware::history_header(network_) + "\n";
    for (const firmware::Snapshot& snapshot : rows_) text += firmware::history_row(snapshot) + "\n";
    return folder_.write("twin.csv", text);
  }
  std::string sqlite() {
    const std::string path = folder_.file("twin.sqlite");
    firmware::SqliteHistory history({path}, network_, troubles_);
    std::atomic<bool> stop{false};
    std::thread writer([&] { history.run(stop); });
    for (const firmware::Snapshot& snapshot : rows_) {
      while (!history.ring().push(snapshot)) std::this_thread::yield();
    }
    stop = true;
    writer.join();
    return path;
  }
  GrowthHistory read(const std::string& path, const std::string& output = "",
                     const std::vector<HandReading>& by_hand = {}) const {
    return read_growth_history(path, output, by_hand, "hand.csv");
  }

  tests::TemporaryFolder folder_;
  rom::Network network_ = tests::small_network();
  firmware::Troubles troubles_;
  std::int64_t started_ns_ = firmware::MonotonicClock().now_ns();
  std::vector<firmware::Snapshot> rows_;
};

TEST_F(Hour, a_touch_off_stands_beside_what_was_published_before_it_was_known) {
  touch(10, 1.5 * um);
  touch(40, 4.5 * um);
  for (const std::string& path : {csv(), sqlite()}) {
    const GrowthHistory history = read(path);
    EXPECT_EQ(history.output, network_.deformations[0].name);
    EXPECT_EQ(history.stretches, 1U);
    ASSERT_EQ(history.readings.size(), 2U) << path;
    EXPECT_NEAR(history.readings[0].predicted_m, 0.9 * um, 1e-12);
    EXPECT_NEAR(history.readings[1].predicted_m, 3.9 * um + 0.05 * um, 1e-12);
    EXPECT_EQ(history.readings[1].measured_m, 4.5 * um);
    EXPECT_NEAR(history.readings[1].unix_s - history.readings[0].unix_s, 1800.0, 1e-3);
  }
}

TEST_F(Hour, the_daemon_finds_the_same_by_halving_its_history) {
  std::mt19937_64 random(20261124);
  for (int n = 0; n < 12; ++n) {
    const auto at = static_cast<int>(random() % 60);
    touch(at, static_cast<double>(random() % 9) * um, static_cast<std::uint32_t>(random() % 2));
    for (std::size_t row = random() % 240; row < rows_.size(); ++row) ++rows_[row].tare_count;
  }
  const std::string path = sqlite();
  const std::string names[2] = {network_.deformations[0].name, network_.deformations[1].name};
  const firmware::FoundTouchOffs found =
      firmware::TouchOffHistory(path, {names[0], names[1]}).read([] { return true; });
  ASSERT_TRUE(found.is_whole);
  for (std::size_t d = 0; d < 2; ++d) {
    const GrowthHistory all = read(path, names[d]);
    EXPECT_EQ(found.outputs[d].stretches, all.stretches);
    ASSERT_EQ(found.outputs[d].readings.size(), all.readings.size()) << d;
    for (std::size_t r = 0; r < all.readings.size(); ++r) {
      EXPECT_EQ(found.outputs[d].readings[r].stretch, all.readings[r].stretch);
      EXPECT_EQ(found.outputs[d].readings[r].measured_m, all.readings[r].measured_m);
      EXPECT_EQ(found.outputs[d].readings[r].predicted_m, all.readings[r].predicted_m);
      EXPECT_NEAR(found.outputs[d].readings[r].unix_s, all.readings[r].unix_s, 1e-3);
    }
  }
}

TEST_F(Hour, touch_offs_of_another_output_belong_to_it) {
  touch(10, 1.5 * um);
  touch(20, -6.0 * um, 1);
  const GrowthHistory history = read(csv(), "flange");
  ASSERT_EQ(history.readings.size(), 1U);
  EXPECT_NEAR(history.readings[0].predicted_m, -0.3 * 19 * um, 1e-12);
}

TEST_F(Hour, a_tare_begins_a_stretch_and_is_no_part_of_the_growth) {
  touch(10, 1.5 * um);
  touch(40, 1.0 * um);
  for (std::size_t n = 30; n < rows_.size(); ++n) {
    rows_[n].tare_count = 1;
    rows_[n].tare_m = 3.0 * um;
  }
  const GrowthHistory history = read(csv());
  EXPECT_EQ(history.stretches, 2U);
  ASSERT_EQ(history.readings.size(), 2U);
  EXPECT_EQ(history.readings[0].stretch, 0U);
  EXPECT_EQ(history.readings[1].stretch, 1U);
  EXPECT_NEAR(history.readings[1].predicted_m, 3.9 * um + 0.05 * um - 3.0 * um, 1e-12);
}

TEST_F(Hour, what_was_written_down_stands_beside_the_cycle_before_its_time) {
  const std::string path = sqlite();
  const double first_s = firmware::SqliteHistoryReader(path).runs()[0].first_unix_s;
  const GrowthHistory history =
      read(path, "", {{first_s + 1230.0, 2.5 * um, true, 3}, {first_s + 630.0, 1.2 * um, false, 2}});
  ASSERT_EQ(history.readings.size(), 2U);
  EXPECT_EQ(history.readings[0].origin, correction::ReadingOrigin::by_hand);
  EXPECT_NEAR(history.readings[0].predicted_m, 1.0 * um, 1e-12);
  EXPECT_EQ(history.readings[1].origin, correction::ReadingOrigin::by_hand_compensated);
  EXPECT_NEAR(history.readings[1].predicted_m, 2.0 * um, 1e-12);
  for (const double off_s : {-10.0, 59 * 60 + 61.0}) {
    EXPECT_EQ(error_of([&] {
                read(path, "", {{first_s + off_s, um, false, 7}});
              }),
              "hand.csv:7: time_utc: the history has no prediction in the minute before this time");
  }
}

TEST_F(Hour, what_was_written_down_between_two_runs_counts_once_by_the_run_that_went_on_then) {
  const std::vector<firmware::Snapshot> whole = rows_;
  std::string path;
  for (const auto& [begin, end] : {std::pair(0, 30), std::pair(30, 60)}) {
    rows_.assign(whole.begin() + begin, whole.begin() + end);
    // The second time another run in the same file, 31 s after the first one's last row.
    for (firmware::Snapshot& snapshot : rows_) snapshot.time_ns -= begin > 0 ? 29'000'000'000 : 0;
    path = sqlite();
  }
  const firmware::SqliteHistoryReader file(path);
  ASSERT_EQ(file.runs().size(), 2U);
  const double second_s = file.runs()[1].first_unix_s;
  const double last_s = file.runs()[0].first_unix_s + 29 * 60;
  ASSERT_GT(second_s, last_s);
  const GrowthHistory history = read(path, "", {{second_s - 0.5, um, false, 2}, {second_s + 0.5, um, false, 3}});
  ASSERT_EQ(history.readings.size(), 2U);
  EXPECT_NEAR(history.readings[0].predicted_m, 2.9 * um, 1e-12);
  EXPECT_NEAR(history.readings[1].predicted_m, 3.0 * um, 1e-12);
  EXPECT_NE(history.readings[0].stretch, history.readings[1].stretch);
}

TEST_F(Hour, what_is_no_history_or_lacks_the_output_is_refused) {
  const std::string history = csv(), name = network_.deformations[0].name;
  EXPECT_EQ(error_of([&] { read(history, "tail"); }), history + ": --output: has no tail; it has " + name + ", flange");
  EXPECT_EQ(error_of([&] {
              read(history, "", {{0.0, um, false, 2}});
            }),
            history + ": has no dates; readings by hand need a history in SQLite");
  const std::string other = folder_.write("other.csv", "time_s,speed_rpm\n0,1\n");
  EXPECT_EQ(error_of([&] { read(other); }), other + ": is no history of spindle-twind with deformations");
  const std::string half = folder_.write("half.csv", "time_s,deformation.nose_um\n0,1\n");
  EXPECT_EQ(error_of([&] { read(half); }), half + ": tare_um: no such column: no history of spindle-twind");
}

TEST(HandReadings, are_read_as_a_person_writes_them) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.write(
      "m.csv",
      "\xEF\xBB\xBFtime_utc, growth_um ,compensated\r\n2026-11-22 08:30,+3.5,0\r\n\r\n2026-11-22T08:31:05Z,-2,1");
  const std::vector<HandReading> readings = read_hand_readings(path);
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].unix_s, 1795336200.0);
  EXPECT_EQ(readings[0].growth_m, 3.5e-6);
  EXPECT_FALSE(readings[0].compensated);
  EXPECT_EQ(readings[1].unix_s - readings[0].unix_s, 65.0);
  EXPECT_TRUE(readings[1].compensated);
  EXPECT_EQ(readings[1].line, 4);
}

TEST(HandReadings, a_wrong_one_is_refused_with_file_line_and_column) {
  const tests::TemporaryFolder folder;
  struct Case {
    const char* text;
    const char* error;
  };
  const char* no_time = ":2: time_utc: must be a time like 2026-11-22 14:05 or 2026-11-22 14:05:30";
  for (const Case& c :
       {Case{"time_utc,growth_um\n22.11.2026 8:30,1\n", no_time},
        {"time_utc,growth_um\n2026-02-30 08:30,1\n", no_time},
        {"time_utc,growth_um\n2026-11-22 08:30 PM,1\n", no_time},
        {"time_utc,growth_um\n2026-11-22 08:30,1e5\n", ":2: growth_um: must be a number from -10000 to 10000"},
        {"time_utc,growth_um\n2026-11-22 08:30,+-1\n", ":2: growth_um: must be a number from -10000 to 10000"},
        {"time_utc,growth_um\n2026-11-22 08:30,nan\n", ":2: growth_um: must be a number from -10000 to 10000"},
        {"time_utc,growth_um,compensated\n2026-11-22 08:30,1,yes\n", ":2: compensated: must be 0 or 1"},
        {"time_utc,growth_um\n2026-11-22 08:30\n", ":2: 1 cells, the header has 2"},
        {"time_utc,growth\n",
         ":1: growth: unknown or given twice; allowed: time_utc, growth_um, "
         "compensated"},
        {"time_utc\n", ":1: growth_um: this column is required"},
        {"time_utc,growth_um\n", ": has no row"}}) {
    const std::string path = folder.write("m.csv", c.text);
    EXPECT_EQ(error_of([&] { read_hand_readings(path); }), path + c.error);
  }
  EXPECT_EQ(error_of([&] { read_hand_readings("/nowhere.csv"); }), "/nowhere.csv: cannot be read");
}

}  // namespace growth_reading_test
}  // namespace spindle_twin::host_tools
