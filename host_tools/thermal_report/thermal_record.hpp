#pragma once

#include <string>
#include <vector>

namespace spindle_twin::host_tools {

/// Readings of one quantity, without the instants at which it was not read.
struct Course {
  std::string name;
  std::vector<double> time_s;
  std::vector<double> value;  ///< um or degC
};

/// A time at one speed.
struct Phase {
  double from_s = 0.0;
  double until_s = 0.0;
  double speed_rpm = 0.0;  ///< mean
};

/// What was measured in a thermal test.
struct ThermalRecord {
  std::string file;
  std::vector<double> time_s, speed_rpm;  ///< of each row
  std::vector<Course> lengths;            ///< measured.<name>_um
  std::vector<Course> temperatures;       ///< measured.<name>_degC
  std::vector<Course> surroundings;       ///< ambient, coolant
  std::vector<std::string> unused;        ///< other columns
};

/// Reads a CSV with time_s, speed_rpm, at least one measured.<name>_um, and as there are measured.<name>_degC,
/// ambient_degC, coolant_degC; all other columns are only named. A log of `replay` and a history are such. Throws
/// rom::InputError with file, line and column for a missing one, an empty cell of time or speed, and times that do not
/// rise.
ThermalRecord read_thermal_record(const std::string& path);

/// Speeds within 1 % of the fastest, or 5 rpm, of the first one of a phase are the same; standstill is 0.
std::vector<Phase> phases_of(const ThermalRecord& record);

}  // namespace spindle_twin::host_tools
