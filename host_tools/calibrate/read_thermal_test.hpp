#pragma once

#include <optional>
#include <string>
#include <vector>

#include "correction/calibrate/thermal_test.hpp"
#include "host_tools/replay/log.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// A log as a thermal test: inputs of each row (an empty cell leaves what was before; what the log does not have is
/// the network's operating state), readings of all key points, and measured lengths: of columns
/// measured.<deformation>_um, else of a history's probes, else its touch-offs since the last tare. Of a history a
/// reading counts where it is new and the daemon believed it. `start_degC`: of the whole spindle; else the mean of the
/// sensors' first readings. Throws rom::InputError with file and column for a log without a key point's reading, and
/// for two rows only.
correction::ThermalTest read_thermal_test(const rom::Network& network, const Log& log,
                                          std::optional<double> start_degC);

/// New readings of each key point that the daemon did not believe, by a history; 0 of other logs.
std::vector<int> readings_left_out(const rom::Network& network, const Log& log);

}  // namespace spindle_twin::host_tools
