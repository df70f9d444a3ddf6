#pragma once

#include <nlohmann/json.hpp>

#include "fem_offline/reduce/worst_search.hpp"

namespace spindle_twin::host_tools {

/// What a search has found, as lines on stdout: the errors, their outputs, and the jumps.
void print_worst_found(const fem_offline::WorstFound& found, const rom::Boundaries& boundaries);

/// The same; of each jump also all factors.
nlohmann::ordered_json worst_found_json(const fem_offline::WorstFound& found, const rom::Boundaries& boundaries);

}  // namespace spindle_twin::host_tools
