#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "fem_offline/mesh/mesh_quality.hpp"

namespace spindle_twin::host_tools {

/// `cells`, and per part cells, least, mean and largest scaled Jacobian, largest aspect, least and longest side in mm.
nlohmann::json mesh_json(const std::vector<fem_offline::PartQuality>& parts);

/// The same as a table on stdout.
void print_mesh_table(const std::vector<fem_offline::PartQuality>& parts);

}  // namespace spindle_twin::host_tools
