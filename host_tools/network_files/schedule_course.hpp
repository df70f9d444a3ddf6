#pragma once

#include <vector>

#include "rom/boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::host_tools {

/// What happens along a schedule: values at every row, all but the environments held until the next.
struct ScheduleCourse {
  std::vector<double> time_s;
  std::vector<rom::BoundaryValues> values;
  std::vector<rom::OperatingState> states;

  /// Mean of every conductance over the time of the schedule, W/m²K.
  Eigen::VectorXd mean_conductances() const;
};

/// Of the nominal network (no correction); laws at their nominal temperatures. `schedule` has two rows or more.
ScheduleCourse course_of(const rom::Boundaries& boundaries, const rom::Schedule& schedule);

}  // namespace spindle_twin::host_tools
