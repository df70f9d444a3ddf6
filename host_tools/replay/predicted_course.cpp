#include "host_tools/replay/predicted_course.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tools/replay/replay.hpp"

namespace spindle_twin::host_tools {

PredictedCourses predicted_courses(const rom::Network& network, const firmware::CyclePlan& plan, const Log& log) {
  PredictedCourses courses;
  for (const rom::DeformationOutput& output : network.deformations)
    courses.deformations.push_back({output.name, {}, {}});
  for (const rom::KeyPoint& point : network.key_points) courses.key_points.push_back({point.name, {}, {}});
  replay(network, plan, log, [&](const ReplayedCycle& cycle) {
    courses.time_s.push_back(cycle.end_s);
    for (std::size_t d = 0; d < courses.deformations.size(); ++d) {
      courses.deformations[d].value.push_back(cycle.snapshot.deformation_m[d]);
      courses.deformations[d].deviation.push_back(cycle.snapshot.deformation_deviation_m[d]);
    }
    for (std::size_t k = 0; k < courses.key_points.size(); ++k) {
      courses.key_points[k].value.push_back(cycle.snapshot.predicted_K[k]);
      courses.key_points[k].deviation.push_back(cycle.snapshot.predicted_deviation_K[k]);
    }
  });
  return courses;
}

double predicted_at(const PredictedCourses& courses, const std::vector<double>& values, double time_s) {
  const std::vector<double>& times = courses.time_s;
  if (times.empty() || !(time_s >= times.front() && time_s <= times.back())) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto after = std::lower_bound(times.begin(), times.end(), time_s);
  const auto at = static_cast<std::size_t>(after - times.begin());
  if (at == 0 || times[at] == time_s) return values[at];
  const double share = (time_s - times[at - 1]) / (times[at] - times[at - 1]);
  return values[at - 1] + share * (values[at] - values[at - 1]);
}

}  // namespace spindle_twin::host_tools
