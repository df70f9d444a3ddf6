#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace spindle_twin::host_tools {

/// How a growth was measured.
enum class ReadingOrigin {
  touch_off,           ///< a length that the PLC handed to the daemon
  by_hand,             ///< the growth itself: a probe, an uncompensated part
  by_hand_compensated  ///< what was left of it while the control compensated: a part
};

/// One measured growth of an output beside what the twin had published before it knew of it, m. Zeros are unknown:
/// only differences within one stretch and origin count.
struct GrowthReading {
  double unix_s = 0.0;
  std::size_t stretch = 0;  ///< from a start or a tare to the next one
  ReadingOrigin origin = ReadingOrigin::touch_off;
  double measured_m = 0.0;
  double predicted_m = 0.0;
};

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
  std::vector<GrowthReading> readings;
};

/// Takes the touch-offs out of a history of spindle-twind (CSV, or all runs of one in SQLite), and puts the readings by
/// hand beside what was published at their time. `output`: name of a deformation; empty: the first, the nose. Throws
/// rom::InputError for a file that is no history, an output that it lacks, readings by hand beside a history in CSV
/// (its rows have no date), and one of a time without a cycle in the minute before.
GrowthHistory read_growth_history(const std::string& path, const std::string& output,
                                  const std::vector<HandReading>& by_hand, const std::string& hand_file);

}  // namespace spindle_twin::host_tools
