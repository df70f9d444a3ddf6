#pragma once

#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "rom/boundary_values/plausible_inputs.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::fem_offline {

/// A value of a description that is not believed, with the line of the table that has it.
struct ImplausibleValue {
  rom::SourceLine where;
  rom::Implausible what;
};

/// What a description says of materials and joints and is more likely a mistake of units (GPa for Pa, µm/mK for 1/K,
/// kelvin for degC) than a spindle:
///   conductivity  0.01 to 2500 W/mK, foam to diamond      density      0.1 to 25,000 kg/m³, gas to osmium
///   heat capacity 50 to 6000 J/kgK, uranium to hydrogen's lighter mixtures and water
///   and, where growth is asked for,
///   Young's modulus 1e6 to 1.3e12 Pa, rubber to diamond   expansion    up to 5e-4 1/K, that of soft polymers
///   temperature without strain  -40 to 100 degC           preload      up to 5e9 Pa, which hardened steel just bears
///   interference  up to 1 % of the fit's radius, beyond which every metal yields
/// Each material, joint and quantity once.
std::vector<ImplausibleValue> implausible_parts(const Spindle& spindle);

}  // namespace spindle_twin::fem_offline
