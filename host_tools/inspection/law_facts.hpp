#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// "bearing_friction of front_inner, front_outer": what a law is and what it reads, for a table.
std::string law_words(const rom::Network& network, const rom::BoundLaw& law);

/// kind, mode, what it reads by name, nominal temperatures in degC, and `numbers` by their SI names.
nlohmann::json law_json(const rom::Network& network, const rom::BoundLaw& law);

}  // namespace spindle_twin::host_tools
