#include "host_tools/commands/offline/progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace spindle_twin::host_tools {
namespace {

constexpr int stage_columns = 18;
constexpr int widest_bar = 40;
constexpr int narrowest_bar = 5;

int terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

std::string progress_line(const std::string& stage, int percent, int columns) {
  std::string line = stage;
  line.resize(std::max(line.size(), static_cast<std::size_t>(stage_columns)), ' ');
  const std::string number = std::to_string(percent);
  const std::string tail = std::string(4 - std::min<std::size_t>(number.size(), 3), ' ') + number + " %";
  const int brackets = 3;
  const int bar = std::min(columns - static_cast<int>(line.size() + tail.size()) - brackets, widest_bar);
  if (bar >= narrowest_bar) {
    const auto done = static_cast<std::size_t>(percent * bar / 100);
    line += " [" + std::string(done, '#') + std::string(static_cast<std::size_t>(bar) - done, ' ') + "]";
  }
  line += tail;
  if (line.size() > static_cast<std::size_t>(columns)) line.resize(static_cast<std::size_t>(std::max(columns, 0)));
  return line;
}

ProgressDisplay::ProgressDisplay() : terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressDisplay::~ProgressDisplay() {
  if (line_open_) std::fputc('\n', stderr);
}

void ProgressDisplay::show(const std::string& stage, double fraction) {
  const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100.0);
  const bool new_stage = stage != shown_stage_;
  if (!new_stage && percent <= shown_percent_) return;
  shown_stage_ = stage;
  shown_percent_ = percent;
  if (!terminal_) {
    if (percent == 100) std::fprintf(stderr, "%s: done\n", stage.c_str());
    return;
  }
  if (new_stage && line_open_) std::fputc('\n', stderr);
  line_open_ = percent < 100;
  // One column less than there are: a full last column makes some terminals wrap. \x1b[K clears what a wider line left.
  const std::string line = progress_line(stage, percent, terminal_columns() - 1);
  std::fprintf(stderr, "\r%s\x1b[K%s", line.c_str(), line_open_ ? "" : "\n");
  std::fflush(stderr);
}

}  // namespace spindle_twin::host_tools
