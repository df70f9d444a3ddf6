#pragma once

#include <optional>

#include "host_tools/thermal_report/thermal_record.hpp"

namespace spindle_twin::host_tools {

/// Of the readings of a course from from_s to until_s, both included; um or K.
struct Drift {
  std::size_t readings = 0;
  double range = 0.0;       ///< highest minus lowest
  double change = 0.0;      ///< last minus first
  double rate_per_h = 0.0;  ///< change by the time between those two
};

/// Empty with fewer than two readings, and where a sixth of the time or more passes without one: what is not read has a
/// range and a rate of its own.
std::optional<Drift> drift_between(const Course& course, double from_s, double until_s);

/// The steepest change between two readings that are at least `span_s` apart and nearest to it, per hour, unsigned;
/// empty where the readings do not span it.
std::optional<double> steepest_per_h(const Course& course, double from_s, double until_s, double span_s);

/// first + swing (1 − e^(−(t − from)/τ)), least squares.
struct TimeConstant {
  double seconds = 0.0;
  double swing = 0.0;  ///< um or K from the begin to the steady state
  double rms = 0.0;    ///< of what is left of the readings
};

/// Least squares in first and swing for each τ, and τ by golden section in ln τ between 10 s and 5 times the span.
/// Empty with fewer than eight readings, where a sixth of the time or more passes without one, where the swing is less
/// than five times the rms that is left, and where τ ends at a border: the readings do not tell it.
std::optional<TimeConstant> fit_time_constant(const Course& course, double from_s, double until_s);

}  // namespace spindle_twin::host_tools
