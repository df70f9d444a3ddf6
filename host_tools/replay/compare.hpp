#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tools/replay/predicted_course.hpp"

namespace spindle_twin::host_tools {

/// One replay of a log, and what is said of it.
struct ReplayedLog {
  std::string name;  ///< network, law and calibration, in words
  PredictedCourses courses;
};

/// Root mean square and worst of a difference.
struct Misfit {
  std::size_t count = 0;
  double rms = 0.0;
  double worst = 0.0;  ///< with its sign
  double worst_at_s = 0.0;
};

/// One output in two replays of the same log, at the instants of the first one; K or m, NaN where nothing is known.
struct ComparedOutput {
  std::string name;
  std::vector<double> measured;               ///< the last reading since the instant before
  std::vector<double> first_off, second_off;  ///< prediction minus that reading, at its own instant
  std::vector<double> first, first_deviation;
  std::vector<double> second, second_deviation;
  std::optional<Misfit> first_error, second_error;  ///< prediction minus reading; empty without a reading
  Misfit difference;                                ///< second minus first
};

struct Comparison {
  std::vector<double> time_s;
  std::vector<ComparedOutput> deformations, key_points;
};

/// Outputs that both networks have, by name. Errors are those of readings of the log at their own instants, each
/// against what was predicted before it was known.
Comparison compare(const rom::Network& network, const Log& log, const ReplayedLog& first, const ReplayedLog& second);

}  // namespace spindle_twin::host_tools
