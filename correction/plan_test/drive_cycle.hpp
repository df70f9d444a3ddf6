#pragma once

#include <vector>

#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::correction {

/// A time at one speed.
struct Stage {
  double length_s = 0.0;
  double speed_rpm = 0.0;

  bool operator==(const Stage& other) const = default;
};

/// What a machine may be asked for in a test.
struct DriveLimits {
  double length_s = 7200.0;
  double top_rpm = 0.0;
  double shortest_s = 300.0;                              ///< at one speed
  std::vector<double> shares{0.0, 0.25, 0.5, 0.75, 1.0};  ///< of top_rpm that may be run at; 0: standstill
  double load = 0.0;
};

using DriveCycle = std::vector<Stage>;

/// As the model takes it: surroundings and flows of the described operating state; load 0 at standstill.
rom::Schedule schedule_of(const DriveCycle& cycle, const DriveLimits& limits, const rom::Boundaries& boundaries);

/// Stages of the same speed become one.
DriveCycle joined(const DriveCycle& cycle);

/// One speed all the time.
DriveCycle constant_cycle(double speed_rpm, double length_s);

/// A spectrum of speeds as ISO 230-3 asks for, which leaves it to the parties: 3 minutes each at 25, 50, 75 and 100 %
/// of the top speed and standstill, again and again.
DriveCycle spectrum_cycle(const DriveLimits& limits);

/// A day of work to be judged by: 4 h of 0 to 100 % of the top speed with pauses, at half load.
rom::Schedule usual_service(double top_rpm, const rom::Boundaries& boundaries);

}  // namespace spindle_twin::correction
