#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What the page of a network shows at an operating state in its steady state, everything else as the file says: nodes
/// with rises, outlines, heat flows and balances of bodies (rom/integrate/heat_flows.hpp), sensitivities of the first
/// deformation (rom/integrate/sensitivity.hpp), time constants with the bodies that take part, certificate. Throws
/// rom::InputError naming `file` if the network has no steady state there.
nlohmann::ordered_json network_page_data(const rom::Network& network, const rom::OperatingState& state,
                                         const std::string& file);

/// The page: one HTML file that needs nothing else.
std::string network_page(const nlohmann::ordered_json& data);

}  // namespace spindle_twin::host_tools
