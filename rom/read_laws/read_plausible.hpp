#pragma once

#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::rom {

/// The table [plausible] of a description, if it has one: { speed_rpm, load, film_W_per_m2K, contact_W_per_m2K, heat_W,
/// result_degC, temperatures_degC.<surrounding>, flows_kg_per_s.<circuit> }, each [lowest, highest]. `environments`,
/// `circuits`: the names that may stand there. Throws InputError for other names and for a range that is empty.
std::vector<PlausibleRange> read_plausible(const TomlTable& root, const std::vector<std::string>& environments,
                                           const std::vector<std::string>& circuits);

}  // namespace spindle_twin::rom
