#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::correction {

/// Contact resistance of an interference fit relative to assembly,
///   R'/R = (1 + dP/P0)^-exponent,  dP = pressure_per_inner_rise · inner_rise − pressure_per_outer_rise · outer_rise,
/// so a hotter inner body presses harder and conducts better. This is the paper's correction with the two
/// defects taken out that make it singular at zero rise and let the resistance only grow.
/// Where the pressure would fall to nothing the result is `maximum`; it is kept inside [minimum, maximum]. Cycle-safe.
double joint_resistance_ratio(const rom::JointFit& fit, double inner_rise_K, double outer_rise_K, double exponent,
                              double minimum, double maximum);

}  // namespace spindle_twin::correction
