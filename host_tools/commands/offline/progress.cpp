#include "host_tools/commands/offline/progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
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

std::string progress_line(const std::string& stage, int percent, int columns, const std::string& left) {
  std::string line = stage;
  line.resize(std::max(line.size(), static_cast<std::size_t>(stage_columns)), ' ');
  const std::string number = std::to_string(percent);
  const std::string tail =
      std::string(4 - std::min<std::size_t>(number.size(), 3), ' ') + number + " %" + (left.empty() ? "" : "  " + left);
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

std::string time_left(double elapsed_s, double fraction) {
  constexpr double least_s = 2.0, minute_s = 60.0;
  if (elapsed_s < least_s || fraction <= 0.0 || fraction >= 1.0) return {};
  const double left_s = elapsed_s * (1.0 - fraction) / fraction;
  if (left_s < 2.0 * minute_s) return "about " + std::to_string(std::max(1L, std::lround(left_s))) + " s left";
  return "about " + std::to_string(std::lround(left_s / minute_s)) + " min left";
}

ProgressDisplay::ProgressDisplay() : terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressDisplay::~ProgressDisplay() {
  if (line_open_) std::fputc('\n', stderr);
}

void ProgressDisplay::show(const std::string& stage, double fraction) {
  const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100.0);
  const bool new_stage = stage != shown_stage_;
  if (!new_stage && percent <= shown_percent_) return;
  const auto now = std::chrono::steady_clock::now();
  if (new_stage) stage_started_ = now, shown_quarter_ = 0;
  shown_stage_ = stage;
  shown_percent_ = percent;
  const double elapsed_s = std::chrono::duration<double>(now - stage_started_).count();
  const std::string left = time_left(elapsed_s, fraction);
  if (!terminal_) {
    constexpr double long_stage_s = 10.0;
    const int quarter = percent / 25;
    if (percent == 100) {
      std::fprintf(stderr, "%s: done\n", stage.c_str());
    } else if (quarter > shown_quarter_ && elapsed_s / fraction > long_stage_s) {
      std::fprintf(stderr, "%s: %d %%%s%s\n", stage.c_str(), percent, left.empty() ? "" : ", ", left.c_str());
    }
    shown_quarter_ = quarter;
    return;
  }
  if (new_stage && line_open_) std::fputc('\n', stderr);
  line_open_ = percent < 100;
  // One column less than there are: a full last column makes some terminals wrap. \x1b[K clears what a wider line left.
  const std::string line = progress_line(stage, percent, terminal_columns() - 1, left);
  std::fprintf(stderr, "\r%s\x1b[K%s", line.c_str(), line_open_ ? "" : "\n");
  std::fflush(stderr);
}

}  // namespace spindle_twin::host_tools
