#include "host_tools/commands/offline/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace spindle_twin::host_tools {

ProgressDisplay::ProgressDisplay() : terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressDisplay::show(const std::string& stage, double fraction) {
  const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100.0);
  if (stage == shown_stage_ && percent <= shown_percent_) return;
  shown_stage_ = stage;
  shown_percent_ = percent;
  if (!terminal_) {
    if (percent == 100) std::fprintf(stderr, "%s: done\n", stage.c_str());
    return;
  }
  constexpr int width = 40;
  const std::string bar(static_cast<std::size_t>(percent * width / 100), '#');
  std::fprintf(stderr, "\r%-20s [%-*s] %3d %%%s", stage.c_str(), width, bar.c_str(), percent,
               percent == 100 ? "\n" : "");
  std::fflush(stderr);
}

}  // namespace spindle_twin::host_tools
