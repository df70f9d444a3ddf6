#include "fem_offline/solve/follow_schedule.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {

namespace {

using Row = std::vector<rom::ScheduleRow>::const_iterator;

/// Whether temperatures run linearly before the row `next`.
bool runs(const rom::Schedule& schedule, Row next) {
  return next != schedule.rows.end() && next != schedule.rows.begin() &&
         next->state.environment_K != std::prev(next)->state.environment_K;
}

}  // namespace

void follow_schedule(const rom::Boundaries& boundaries, const rom::Schedule& schedule, const ScheduleSpan& span,
                     FeStepper& stepper, rom::BoundaryValues& values) {
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::OperatingState state = boundaries.operating;
  double time_s = span.from_s;
  while (time_s < span.until_s) {
    const auto next = std::upper_bound(schedule.rows.begin(), schedule.rows.end(), time_s,
                                       [](double at_s, const auto& row) { return at_s < row.time_s; });
    double end_s = next == schedule.rows.end() ? span.until_s : std::min(span.until_s, next->time_s);
    if (runs(schedule, next)) end_s = std::min(end_s, time_s + span.max_step_s);
    rom::state_at(schedule, 0.5 * (time_s + end_s), state);
    rom::evaluate_boundaries(boundaries, state, factors, values);
    if (span.tolerance_K > 0.0) {
      stepper.advance_within(end_s - time_s, span.tolerance_K, values);
    } else {
      stepper.advance(end_s - time_s, span.max_step_s, values);
    }
    time_s = end_s;
  }
}

}  // namespace spindle_twin::fem_offline
