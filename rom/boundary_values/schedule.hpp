#pragma once

#include <string>
#include <vector>

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// One row of a schedule: what holds from time_s on.
struct ScheduleRow {
  double time_s = 0.0;
  OperatingState state;
  int line = 0;  ///< of the file, where it comes from one
};

/// A drive cycle. Speed, load, current, power, measured heats and coolant flows hold until the next row; environment
/// temperatures run linearly to the next row.
struct Schedule {
  std::vector<ScheduleRow> rows;  ///< strictly rising times, the first at 0
  double end_s = 0.0;
};

/// Reads a CSV with header time_s,speed_rpm,load and optionally one <environment>_degC column per environment and one
/// <circuit>_kg_per_s column per coolant circuit (missing ones keep the description's operating state); current_A and
/// power_W where a heat follows them (missing ones: heats follow the load); heat.<source>_W per measured heat (missing
/// ones: as its law says). The last row's time is the end. Throws
/// InputError with file, line and column for an unknown column, a missing one, a non-finite value, times that do
/// not rise.
Schedule read_schedule(const std::string& path, const Boundaries& boundaries);

/// The state at time_s (clamped to the schedule). Cycle-safe when `state` is already sized.
void state_at(const Schedule& schedule, double time_s, OperatingState& state);

/// A schedule that holds the description's operating state for duration_s.
Schedule constant_schedule(const Boundaries& boundaries, double duration_s);

}  // namespace spindle_twin::rom
