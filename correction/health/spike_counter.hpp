#pragma once

#include <algorithm>
#include <array>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Single readings that were far off and came back, counted over a window of time. May run in the cycle.
class SpikeCounter {
 public:
  SpikeCounter() { times_s_.fill(never_s); }

  /// One more at time_s. True where they are too many within limits.spike_window_s, at most 16; counting begins anew.
  bool note(double time_s, const HealthLimits& limits) {
    constexpr auto room = static_cast<int>(std::tuple_size_v<decltype(times_s_)>);
    times_s_[static_cast<std::size_t>(at_)] = time_s;
    at_ = (at_ + 1) % room;
    const auto recent = std::count_if(times_s_.begin(), times_s_.end(),
                                      [&](double at_s) { return time_s - at_s <= limits.spike_window_s; });
    if (recent < std::min(limits.spikes, room)) return false;
    times_s_.fill(never_s);
    return true;
  }

 private:
  static constexpr double never_s = -1e18;
  std::array<double, 16> times_s_{};
  int at_ = 0;
};

}  // namespace spindle_twin::correction
