#pragma once

#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::fem_offline {

/// A stretch of a schedule, and how long a step in it may be.
struct ScheduleSpan {
  double from_s = 0.0;
  double until_s = 0.0;
  double max_step_s = 1.0;
};

/// Carries `stepper` over the span along the schedule. Inputs are held over
/// a step at their value in its middle, and jump only between steps. `values` (sized for `boundaries`) is left at the
/// inputs of the last step. Past its end the schedule's last state holds.
void follow_schedule(const rom::Boundaries& boundaries, const rom::Schedule& schedule, const ScheduleSpan& span,
                     FeStepper& stepper, rom::BoundaryValues& values);

}  // namespace spindle_twin::fem_offline
