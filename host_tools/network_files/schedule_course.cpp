#include "host_tools/network_files/schedule_course.hpp"

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::host_tools {

Eigen::VectorXd ScheduleCourse::mean_conductances() const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(values.front().conductance_W_per_m2K.size());
  for (std::size_t row = 0; row + 1 < values.size(); ++row) {
    sum += (time_s[row + 1] - time_s[row]) * values[row].conductance_W_per_m2K;
  }
  return sum / (time_s.back() - time_s.front());
}

ScheduleCourse course_of(const rom::Boundaries& boundaries, const rom::Schedule& schedule) {
  ScheduleCourse course;
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  for (const rom::ScheduleRow& row : schedule.rows) {
    course.time_s.push_back(row.time_s);
    course.states.push_back(row.state);
    course.values.push_back(rom::make_boundary_values(boundaries));
    rom::evaluate_boundaries(boundaries, row.state, factors, course.values.back());
  }
  // The last row is the end: nothing begins there.
  course.values.back().heat_W = (course.values.end() - 2)->heat_W;
  course.values.back().conductance_W_per_m2K = (course.values.end() - 2)->conductance_W_per_m2K;
  course.values.back().coolant_W_per_K = (course.values.end() - 2)->coolant_W_per_K;
  return course;
}

}  // namespace spindle_twin::host_tools
