#include "firmware/watch/log.hpp"

#include <poll.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

namespace spindle_twin::firmware {

/// Shared by the sink, the writing thread and the Log: whichever lives longest.
struct Log::Lines {
  Lines(int to, std::size_t most, std::atomic<std::uint64_t>& count) : descriptor(to), room(most), dropped(count) {}

  void add(std::string line) {
    const std::lock_guard lock(mutex);
    if (waiting.size() < room) {
      waiting.push_back(std::move(line));
      changed.notify_all();
    } else if (!closing) {
      ++dropped;
      ++untold;
    }
  }

  const int descriptor;
  const std::size_t room;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> waiting;
  bool closing = false;
  bool ended = false;
  std::atomic<std::uint64_t>& dropped;  // not after `closing`
  std::uint64_t untold = 0;
};

namespace {

/// Whether it took the line. Waits for a reader: a pipe with room for PIPE_BUF bytes does not block such a write.
bool write_line(int descriptor, std::string_view line) {
  constexpr std::size_t most_at_once = 4096;
  while (!line.empty()) {
    pollfd writable{descriptor, POLLOUT, 0};
    if (poll(&writable, 1, -1) < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    const ssize_t written = ::write(descriptor, line.data(), std::min(line.size(), most_at_once));
    if (written < 0 && errno != EINTR && errno != EAGAIN) return false;
    if (written > 0) line.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

template <class Shared>
void write_lines(const Shared& lines) {
  std::unique_lock lock(lines->mutex);
  while (true) {
    lines->changed.wait(lock, [&] { return lines->closing || !lines->waiting.empty(); });
    if (lines->waiting.empty()) break;
    const std::string line = std::move(lines->waiting.front());
    lines->waiting.pop_front();
    const std::uint64_t untold = std::exchange(lines->untold, 0);
    lock.unlock();
    bool taken = write_line(lines->descriptor, line);
    if (taken && untold > 0) {
      taken = write_line(lines->descriptor, fmt::format("({} lines of the log were dropped here)\n", untold));
    }
    lock.lock();
    if (!taken) {
      lines->untold += untold + 1;
      if (!lines->closing) ++lines->dropped;
    }
  }
  lines->ended = true;
  lines->changed.notify_all();
}

/// Whether the descriptor is the journal of the service manager (systemd.exec(5), JOURNAL_STREAM).
bool is_journal(int descriptor) {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || fstat(descriptor, &status) != 0) return false;
  return stream == fmt::format("{}:{}", status.st_dev, status.st_ino);
}

/// How the journal reads a line's severity (sd-daemon(3)).
const char* severity(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::trace:
    case spdlog::level::debug:
      return "<7>";
    case spdlog::level::info:
      return "<6>";
    case spdlog::level::warn:
      return "<4>";
    default:
      return "<3>";
  }
}

/// What LogName says of this thread. A line is formatted by the thread that writes it.
thread_local std::string name_of_thread;

class NameFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& /*message*/, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    if (name_of_thread.empty()) return;
    line.append(name_of_thread.data(), name_of_thread.data() + name_of_thread.size());
    constexpr std::string_view mark = ": ";
    line.append(mark.data(), mark.data() + mark.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<NameFlag>(); }
};

template <class Shared>
class Sink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  Sink(Shared lines, bool to_journal) : lines_(std::move(lines)), to_journal_(to_journal) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    lines_->add((to_journal_ ? severity(message.level) : "") + fmt::to_string(text));
  }
  void flush_() override {}

  Shared lines_;
  bool to_journal_;
};

}  // namespace

Log::Log(const std::string& level, int descriptor, std::atomic<std::uint64_t>& dropped, std::size_t room)
    : lines_(std::make_shared<Lines>(descriptor, room, dropped)) {
  using Shared = std::shared_ptr<Lines>;
  const bool to_journal = is_journal(descriptor);  // which has time and severity of its own
  auto logger = std::make_shared<spdlog::logger>("spindle-twind", std::make_shared<Sink<Shared>>(lines_, to_journal));
  logger->set_level(spdlog::level::from_str(level));
  auto form = std::make_unique<spdlog::pattern_formatter>();
  form->add_flag<NameFlag>('*').set_pattern(to_journal ? "%*%v" : "%Y-%m-%d %H:%M:%S.%e %l %*%v");
  logger->set_formatter(std::move(form));
  spdlog::set_default_logger(logger);
  // Not joined: it may hang in a write that nobody reads, and then goes with the program.
  std::thread([lines = lines_] { write_lines(lines); }).detach();
}

LogName::LogName(const std::string& name) : before_(std::exchange(name_of_thread, name)) {}
LogName::~LogName() { name_of_thread = std::move(before_); }

Log::~Log() {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("ended"));
  std::unique_lock lock(lines_->mutex);
  lines_->closing = true;
  lines_->changed.notify_all();
  lines_->changed.wait_for(lock, std::chrono::seconds(1), [&] { return lines_->ended; });
}

}  // namespace spindle_twin::firmware
