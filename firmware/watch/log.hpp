#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace spindle_twin::firmware {

/// While it lives, the program's log (spdlog's default logger) goes to a file descriptor from a thread of its own: who
/// logs never waits for who reads. At most `room` lines wait; what comes then is dropped and counted, and a line says
/// so when there is a reader again. The program must ignore SIGPIPE. Lines for the journal of a service manager carry
/// their severity in its form and no time.
class Log {
 public:
  /// `level`: debug, info, warning or error. `dropped` is counted up and must outlive this.
  Log(const std::string& level, int descriptor, std::atomic<std::uint64_t>& dropped, std::size_t room = 1000);
  /// What still waits is written, for a second at most.
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

 private:
  struct Lines;
  std::shared_ptr<Lines> lines_;
};

/// While it lives, lines of the log that this thread writes begin with "NAME: "; an empty name adds nothing.
class LogName {
 public:
  explicit LogName(const std::string& name);
  ~LogName();
  LogName(const LogName&) = delete;
  LogName& operator=(const LogName&) = delete;

 private:
  std::string before_;
};

}  // namespace spindle_twin::firmware
