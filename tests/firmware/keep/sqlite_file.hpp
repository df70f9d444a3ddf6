#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/read/input_error.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {

/// A history in SQLite that tests write and read.
class SqliteFile : public ::testing::Test {
 protected:
  /// Writes these cycles and ends.
  void write_cycles(HistoryWriter& history, std::uint64_t first, std::uint64_t last) {
    std::atomic<bool> stop{false};
    std::thread writer([&] { history.run(stop); });
    Snapshot snapshot = first_snapshot(network_);
    for (snapshot.sequence = first; snapshot.sequence <= last; ++snapshot.sequence) {
      snapshot.time_ns = MonotonicClock().now_ns();
      change_(snapshot);
      while (!history.ring().push(snapshot)) std::this_thread::yield();
    }
    stop.store(true);
    writer.join();
  }
  void write_run(std::uint64_t last) {
    SqliteHistory history({path_}, network_, troubles_);
    write_cycles(history, 1, last);
  }
  rom::CsvTable table(std::optional<std::int64_t> run = std::nullopt) const {
    return SqliteHistoryReader(path_).table(run);
  }
  std::vector<HistoryRun> runs() const { return SqliteHistoryReader(path_).runs(); }
  bool is_at_fault() const { return (troubles_.faults() & bits(Fault::history_lost)) != 0; }
  std::string error_of(const std::string& path) const {
    try {
      const SqliteHistoryReader reader(path);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  rom::Network network_ = tests::small_network();
  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("history.sqlite");
  Troubles troubles_;
  std::function<void(Snapshot&)> change_ = [](Snapshot&) {};
};

/// In one transaction, as many as the ring takes.
inline void write_at_once(HistoryWriter& history, const std::vector<Snapshot>& cycles) {
  for (const Snapshot& cycle : cycles) ASSERT_TRUE(history.ring().push(cycle));
  history.run(std::atomic<bool>(true));
}

/// Cycles of so many seconds ago.
inline std::vector<Snapshot> cycles_at(const rom::Network& network, const std::vector<std::int64_t>& seconds_ago) {
  std::vector<Snapshot> cycles(seconds_ago.size(), first_snapshot(network));
  const std::int64_t now_ns = MonotonicClock().now_ns();
  for (std::size_t n = 0; n < cycles.size(); ++n) {
    cycles[n].sequence = n + 1;
    cycles[n].time_ns = now_ns - seconds_ago[n] * 1'000'000'000;
  }
  return cycles;
}

}  // namespace spindle_twin::firmware
