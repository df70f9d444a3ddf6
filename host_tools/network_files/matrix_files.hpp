#pragma once

#include <string>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// Writes the network into the new folder `directory`: one Matrix Market file per matrix of rom::Network's equation
/// (capacity, conduction, factor_<j>, source_distribution) and per list of outputs (key_points, part_means,
/// part_candidates_<p>, deformations, contact_pressures), `network.json` with names, units and the values of the
/// operating state in the order of rows and columns, and README.md with the equation. Every number is read back and is
/// the same to the last bit. Throws rom::InputError if the folder is there and not empty or cannot be written; then
/// nothing of it stays.
void write_matrix_files(const rom::Network& network, const std::string& directory);

}  // namespace spindle_twin::host_tools
