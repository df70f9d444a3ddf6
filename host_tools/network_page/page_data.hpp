#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What the page of a network (host_tools/pages/network_page.js) shows at an operating state in its steady state, and
/// on the way there (warm_up.hpp), everything else as the file says: nodes with rises, outlines, heat flows and
/// balances of bodies (rom/integrate/heat_flows.hpp), sensitivities of the first deformation
/// (rom/integrate/sensitivity.hpp), time constants with the bodies that take part, certificate. Throws rom::InputError
/// naming `file` if the network has no steady state there.
nlohmann::ordered_json network_page_data(const rom::Network& network, const rom::OperatingState& state,
                                         const std::string& file);

}  // namespace spindle_twin::host_tools
