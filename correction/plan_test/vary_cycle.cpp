#include "correction/plan_test/vary_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spindle_twin::correction {

DriveCycle in_stages(std::size_t stages, const std::vector<double>& shares, const DriveLimits& limits) {
  DriveCycle cycle;
  for (std::size_t k = 0; k < stages; ++k) {
    cycle.push_back({limits.length_s / static_cast<double>(stages), shares[k % shares.size()] * limits.top_rpm});
  }
  return cycle;
}

std::vector<DriveCycle> other_speeds(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits) {
  std::vector<DriveCycle> others;
  for (const double share : limits.shares) {
    DriveCycle other = cycle;
    other[stage].speed_rpm = share * limits.top_rpm;
    if (other != cycle) others.push_back(std::move(other));
  }
  return others;
}

std::vector<DriveCycle> other_times(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits,
                                    std::initializer_list<double> steps_s) {
  std::vector<DriveCycle> others;
  for (const double step_s : steps_s) {
    for (const double shift_s : {-step_s, step_s}) {
      DriveCycle other = cycle;
      other[stage].length_s += shift_s;
      other[stage + 1].length_s -= shift_s;
      const bool allowed = std::min(other[stage].length_s, other[stage + 1].length_s) >= limits.shortest_s;
      if (shift_s != 0.0 && allowed) others.push_back(std::move(other));
    }
  }
  return others;
}

double half_in_minutes_s(double length_s) { return std::floor(0.5 * length_s / 60.0) * 60.0; }

std::vector<DriveCycle> splits(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits) {
  std::vector<DriveCycle> others;
  const Stage whole = cycle[stage];
  for (const double part_s : {limits.shortest_s, half_in_minutes_s(whole.length_s)}) {
    if (std::min(part_s, whole.length_s - part_s) < limits.shortest_s) continue;
    for (const double share : limits.shares) {
      const Stage added{part_s, share * limits.top_rpm}, kept{whole.length_s - part_s, whole.speed_rpm};
      if (added.speed_rpm == whole.speed_rpm) continue;
      for (const bool first : {true, false}) {
        DriveCycle other = cycle;
        other[stage] = first ? added : kept;
        other.insert(other.begin() + static_cast<std::ptrdiff_t>(stage) + 1, first ? kept : added);
        others.push_back(joined(other));
      }
    }
  }
  return others;
}

}  // namespace spindle_twin::correction
