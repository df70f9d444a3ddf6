#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// From rest at the temperature of the surroundings, `state` held and nothing corrected, through the daemon's
/// integrator, for about five times `time_constant_s` (four minutes to 30 days in all), in 240 steps of whole seconds:
/// `time_s`, `key_points` (`name`, `rises_K` above the rest), `deformations` (`name`, `um`). Throws rom::InputError
/// naming `file` if the network cannot be integrated.
nlohmann::ordered_json warm_up_json(const rom::Network& network, const rom::OperatingState& state,
                                    double time_constant_s, const std::string& file);

}  // namespace spindle_twin::host_tools
