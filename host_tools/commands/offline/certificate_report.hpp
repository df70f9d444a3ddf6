#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// {cases, seed, worst, median, box, mesh, outputs{key_points_K, part_mean_K, part_max_K, deformations_um,
/// contact_pressures_Pa}}, each of the last by name {worst, median, mesh}.
nlohmann::ordered_json to_json(const rom::Network& network);

/// The same as lines on stdout.
void print_certificate(const rom::Network& network);

}  // namespace spindle_twin::host_tools
