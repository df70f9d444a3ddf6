#pragma once

#include <optional>

#include "host_tools/replay/log.hpp"

namespace spindle_twin::host_tools {

/// What is assumed of a log that does not show its resolution.
inline constexpr double coarsest_resolution_K = 1.0;

/// The finest step of a sensor's readings in K, 0.01 to 1, as far as they change every few seconds (nine stretches of
/// ten without a change last at most 10 s): of a log that holds them for longer nobody knows whether a sensor stands or
/// its logger waits. Of a sensor that never changes that of the others, which one logger has written.
double resolution_of_log_K(const Log& log, std::size_t sensor);

/// 1 sigma of what a reading scatters by, K: 1.4826 median |r₀ − 2 r₁ + r₂| / √6 over three readings behind each other,
/// on which a smooth course leaves nothing. 0 with fewer than three, and where most repeat the one before.
double noise_of_log_K(const Log& log, std::size_t sensor);

/// Mean of the first readings of all sensors that have read within a minute of the first one: what comes later no
/// longer shows the start. Readings that a daemon did not believe are none. Empty where there is no reading.
std::optional<double> start_of_log_K(const Log& log);

}  // namespace spindle_twin::host_tools
