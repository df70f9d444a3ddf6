#pragma once

#include <string>

namespace spindle_twin::host_tools {

/// Progress on stderr: a bar that is redrawn on a terminal, one line per finished stage otherwise.
class ProgressDisplay {
 public:
  ProgressDisplay();
  void show(const std::string& stage, double fraction);

 private:
  bool terminal_;
  int shown_percent_ = -1;
  std::string shown_stage_;
};

}  // namespace spindle_twin::host_tools
