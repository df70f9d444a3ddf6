#pragma once

#include <cmath>
#include <limits>

#include "correction/paper/paper_options.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::correction {

/// When speed or load last changed by more than the guards allow. May run in the cycle.
class OperatingChanges {
 public:
  /// From here on, as if nothing had ever changed.
  void reset(const rom::OperatingState& operating) {
    speed_rpm_ = operating.speed_rpm;
    load_ = operating.load;
    changed_s_ = -std::numeric_limits<double>::infinity();
  }

  void watch(double time_s, const rom::OperatingState& operating, const PaperGuards& guards) {
    if (std::abs(operating.speed_rpm - speed_rpm_) <= guards.speed_change_rpm &&
        std::abs(operating.load - load_) <= guards.load_change) {
      return;
    }
    speed_rpm_ = operating.speed_rpm;
    load_ = operating.load;
    changed_s_ = time_s;
  }

  double since_s(double time_s) const { return time_s - changed_s_; }

 private:
  double speed_rpm_ = 0.0, load_ = 0.0;  ///< since that change
  double changed_s_ = -std::numeric_limits<double>::infinity();
};

}  // namespace spindle_twin::correction
