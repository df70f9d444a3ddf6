#include "fem_offline/solve/follow_schedule.hpp"

#include <algorithm>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {

void follow_schedule(const rom::Boundaries& boundaries, const rom::Schedule& schedule, const ScheduleSpan& span,
                     FeStepper& stepper, rom::BoundaryValues& values) {
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::OperatingState state = boundaries.operating;
  double time_s = span.from_s;
  while (time_s < span.until_s) {
    const auto next = std::upper_bound(schedule.rows.begin(), schedule.rows.end(), time_s,
                                       [](double at_s, const auto& row) { return at_s < row.time_s; });
    const double end_s = next == schedule.rows.end() ? span.until_s : std::min(span.until_s, next->time_s);
    rom::state_at(schedule, 0.5 * (time_s + end_s), state);
    rom::evaluate_boundaries(boundaries, state, factors, values);
    stepper.advance(end_s - time_s, span.max_step_s, values);
    time_s = end_s;
  }
}

}  // namespace spindle_twin::fem_offline
