#pragma once

#include <cstddef>
#include <initializer_list>
#include <vector>

#include "correction/plan_test/drive_cycle.hpp"

/// What the search for a drive cycle (plan_cycle) begins with and how it moves on. A move gives cycles of the same
/// length as the one that it varies; no stage becomes shorter than limits.shortest_s. `stage` counts from 0 and is one
/// of the cycle's. Nothing here may run in the daemon's cycle.
namespace spindle_twin::correction {

/// `stages` stages of equal length, limits.length_s together, with these shares of the top speed, again and again.
DriveCycle in_stages(std::size_t stages, const std::vector<double>& shares, const DriveLimits& limits);

/// The stage at each other of the speeds that are allowed.
std::vector<DriveCycle> other_speeds(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits);

/// The switch from `stage`, not the last, to the next one earlier and later by these times, as far as both stages stay
/// long enough.
std::vector<DriveCycle> other_times(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits,
                                    std::initializer_list<double> steps_s);

/// Each other speed in the first or last part of a stage: in as short a one as is allowed, and in half of it. Stages of
/// one speed become one.
std::vector<DriveCycle> splits(const DriveCycle& cycle, std::size_t stage, const DriveLimits& limits);

/// Half of a length [s], rounded down to whole minutes, which a person can run. [s]
double half_in_minutes_s(double length_s);

}  // namespace spindle_twin::correction
