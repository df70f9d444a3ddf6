#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// scale(x, load) of SpeedLaw with x = |speed_rpm| / reference_speed_rpm. Cycle-safe.
double evaluate_speed_law(const SpeedLaw& law, double speed_rpm, double reference_speed_rpm, double load);

}  // namespace spindle_twin::rom
