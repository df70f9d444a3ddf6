#pragma once

#include <string>
#include <vector>

#include "host_tools/replay/log.hpp"
#include "host_tools/replay/plan.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What a replay said of one deformation output or key point, cycle after cycle.
struct PredictedCourse {
  std::string name;
  std::vector<double> value;      ///< m or K, at PredictedCourses::time_s
  std::vector<double> deviation;  ///< 1σ, NaN where none is published
};

struct PredictedCourses {
  std::vector<double> time_s;  ///< what each is for, in the log's time
  std::vector<PredictedCourse> deformations;
  std::vector<PredictedCourse> key_points;
};

/// Replays the log with this plan and keeps what was predicted. Throws as replay does.
PredictedCourses predicted_courses(const rom::Network& network, const firmware::CyclePlan& plan, const Log& log);

/// The prediction at an instant, linear between cycles; NaN before the first and after the last one.
double predicted_at(const PredictedCourses& courses, const std::vector<double>& values, double time_s);

}  // namespace spindle_twin::host_tools
