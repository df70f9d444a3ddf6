#pragma once

#include <malloc.h>

#include <chrono>
#include <ctime>
#include <string>

#include "fem_offline/reduce/reduce.hpp"

namespace spindle_twin::fem_offline {

/// Adds stage after stage to a report, each with the time since the one before, and gives back what memory a stage has
/// freed: the next one holds other large matrices.
class StageClock {
 public:
  /// `report` may be nullptr, for a caller that wants none.
  explicit StageClock(ReduceReport* report, const Progress& progress = {}) : report_(report), progress_(progress) {}

  void finish(const std::string& stage) {
    malloc_trim(0);
    const auto now = Clock::now();
    const double processor_s = used_s();
    if (report_) {
      report_->stages.push_back({stage, std::chrono::duration<double>(now - started_).count(), processor_s - used_s_});
    }
    started_ = now;
    used_s_ = processor_s;
    if (progress_) progress_(stage, 1.0);
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// Of all threads of the program.
  static double used_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

  ReduceReport* report_;
  Progress progress_;
  Clock::time_point started_ = Clock::now();
  double used_s_ = used_s();
};

}  // namespace spindle_twin::fem_offline
