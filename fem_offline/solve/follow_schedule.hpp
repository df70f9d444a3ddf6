#pragma once

#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::fem_offline {

/// A stretch of a schedule, and how long a step in it may be, or with tolerance_K > 0 how much each may err
/// (FeStepper::advance_within).
struct ScheduleSpan {
  double from_s = 0.0;
  double until_s = 0.0;
  double max_step_s = 1.0;
  double tolerance_K = 0.0;
};

/// Carries `stepper` over the span along the schedule. Inputs jump only between steps; temperatures that run linearly
/// are held over max_step_s at their value in its middle. `values` (sized for `boundaries`) is left at the
/// inputs of the last step. Past its end the schedule's last state holds.
void follow_schedule(const rom::Boundaries& boundaries, const rom::Schedule& schedule, const ScheduleSpan& span,
                     FeStepper& stepper, rom::BoundaryValues& values);

}  // namespace spindle_twin::fem_offline
