#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "correction/growth/growth_reading.hpp"

namespace spindle_twin::host_tools {

/// A measurement that a person has written down, line by line.
struct HandReading {
  double unix_s = 0.0;
  double growth_m = 0.0;
  bool compensated = false;
  int line = 0;
};

/// Reads a CSV with the columns time_utc (2026-11-22 14:05 or with seconds), growth_um (+ = spindle longer) and, if any
/// was taken while the control compensated, compensated (0 or 1); times need not rise. Throws rom::InputError with
/// file, line and column for an unknown or missing column, a time that is none, a number that is none or beyond 10 mm,
/// and a file without a row.
std::vector<HandReading> read_hand_readings(const std::string& path);

/// What a history says: its output's growth readings in the order of time.
struct GrowthHistory {
  std::string output;
  bool has_clock = false;  ///< unix_s is one; else the history's own time
  std::size_t stretches = 0;
  std::vector<correction::GrowthReading> readings;
};

/// Takes the touch-offs out of a history of spindle-twind (CSV, or all runs of one in SQLite), and puts the readings by
/// hand beside what was published at their time. `output`: name of a deformation; empty: the first, the nose. Throws
/// rom::InputError for a file that is no history, an output that it lacks, readings by hand beside a history in CSV
/// (its rows have no date), and one of a time without a cycle in the minute before.
GrowthHistory read_growth_history(const std::string& path, const std::string& output,
                                  const std::vector<HandReading>& by_hand, const std::string& hand_file);

}  // namespace spindle_twin::host_tools
