#pragma once

#include <cstddef>
#include <string>

namespace spindle_twin::fem_offline {

/// Writes the shell script `run` of a CalculiX deck: all analyses in their order. CalculiX steps in time with first
/// order; the script combines two runs, twice the solution minus the one with doubled steps, to second order.
void write_calculix_run(std::size_t nodes, bool with_growth, const std::string& directory);

}  // namespace spindle_twin::fem_offline
