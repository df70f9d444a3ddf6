#include "firmware/keep/history_writer.hpp"

#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>
#include <utility>

#include "firmware/keep/history.hpp"
#include "firmware/keep/sqlite_history.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

HistoryWriter::HistoryWriter(std::string path, Troubles& troubles) : path_(std::move(path)), troubles_(troubles) {}

void HistoryWriter::run(const std::atomic<bool>& stop) {
  bool last = false;
  while (!last) {
    last = stop.load(std::memory_order_acquire);
    drain();
    troubles_.history_rows_lost.store(lost_.load(), std::memory_order_relaxed);
    if (!last) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  if (const std::uint64_t rows = lost_.load(); rows > 0) spdlog::warn("history {}: {} rows lost", path_, rows);
}

void HistoryWriter::complain(const std::string& what, const std::string& reason) {
  troubles_.set(Fault::history_lost, true);
  const std::int64_t now_ns = MonotonicClock().now_ns();
  try_from_ns_ = now_ns + 1'000'000'000;
  const auto before = complaints_.pass(now_ns);
  if (before) spdlog::error("history {}: {}: {}; rows are lost{}", path_, what, reason, LogLimit::also(*before));
}

void HistoryWriter::note_file() {
  struct stat status {};
  const bool known = stat(path_.c_str(), &status) == 0;
  device_ = known ? status.st_dev : 0;
  inode_ = known ? status.st_ino : 0;
}

bool HistoryWriter::is_gone() const {
  struct stat status {};
  if (inode_ == 0) return false;
  return stat(path_.c_str(), &status) != 0 || status.st_dev != device_ || status.st_ino != inode_;
}

bool HistoryWriter::may_try() const { return MonotonicClock().now_ns() >= try_from_ns_; }

void HistoryWriter::works() {
  if ((troubles_.faults() & bits(Fault::history_lost)) != 0) spdlog::info("history {}: is written again", path_);
  troubles_.set(Fault::history_lost, false);
}

std::unique_ptr<HistoryWriter> make_history(const HistoryPlan& plan, const rom::Network& network, Troubles& troubles) {
  if (is_sqlite_path(plan.path)) return std::make_unique<SqliteHistory>(plan, network, troubles);
  return std::make_unique<History>(plan, network, troubles);
}

}  // namespace spindle_twin::firmware
