#pragma once

#include <string>

namespace spindle_twin::host_tools {

/// One line of progress, at most `columns` wide: stage, bar, percent; the bar shrinks and goes first when space is
/// short.
std::string progress_line(const std::string& stage, int percent, int columns);

/// Progress on stderr: on a terminal a bar that is redrawn in place, one line per stage; otherwise one line per
/// finished stage. An unfinished bar gets its line end when the display is destroyed, so that an error starts a new
/// line.
class ProgressDisplay {
 public:
  ProgressDisplay();
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void show(const std::string& stage, double fraction);

 private:
  bool terminal_;
  bool line_open_ = false;
  int shown_percent_ = -1;
  std::string shown_stage_;
};

}  // namespace spindle_twin::host_tools
