#pragma once

#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::fem_offline {

/// Carries `stepper` from from_s to until_s along the schedule in steps no longer than max_step_s. Inputs are held over
/// a step at their value in its middle, and jump only between steps. `values` (sized for `boundaries`) is left at the
/// inputs of the last step. Past its end the schedule's last state holds.
void follow_schedule(const rom::Boundaries& boundaries, const rom::Schedule& schedule, double from_s, double until_s,
                     double max_step_s, FeStepper& stepper, rom::BoundaryValues& values);

}  // namespace spindle_twin::fem_offline
