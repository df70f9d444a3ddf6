#pragma once

#include <optional>

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// Temperature of the first environment of a kind in a state; empty without one. Cycle-safe.
std::optional<double> first_environment_K(const Boundaries& boundaries, EnvironmentKind kind,
                                          const OperatingState& state);

/// Where a spindle ends that stood long enough: the temperature of the first ambient environment, without one that of
/// the first environment, without any the reference temperature. Cycle-safe.
double rest_temperature_K(const Boundaries& boundaries, const OperatingState& state);

}  // namespace spindle_twin::rom
