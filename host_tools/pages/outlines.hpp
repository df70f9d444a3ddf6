#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// The outlines of a network's parts as section.js takes them: list of {part, points_m: [[r, z], ...]}; empty where
/// nobody drew the section.
nlohmann::ordered_json outlines_json(const rom::Network& network);

}  // namespace spindle_twin::host_tools
