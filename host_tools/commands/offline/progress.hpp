#pragma once

#include <chrono>
#include <string>

namespace spindle_twin::host_tools {

/// One line of progress, at most `columns` wide: stage, bar, percent, time left; the bar shrinks and goes first when
/// space is short. `left` as time_left() gives it, empty for none.
std::string progress_line(const std::string& stage, int percent, int columns, const std::string& left = "");

/// "about 40 s left" or "about 3 min left", from the time that `fraction` of the work took; empty below 2 s of it,
/// where nothing is known yet, and when all is done.
std::string time_left(double elapsed_s, double fraction);

/// Progress on stderr: on a terminal a bar that is redrawn in place, one line per stage; otherwise one line per
/// finished stage, and one at every quarter of a stage that takes longer than 10 s. An unfinished bar gets its line end
/// when the display is destroyed, so that an error starts a new line.
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
  int shown_quarter_ = 0;
  std::chrono::steady_clock::time_point stage_started_;
  std::string shown_stage_;
};

}  // namespace spindle_twin::host_tools
