#pragma once

#include <string>

#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// What of a spindle does not change while its network runs, for the live page: {"notice" (what its reader is to know
/// first: that it is simulated), "has_history" (whether there are hours and days to ask for), "outlines" [{"part",
/// "points_m"}], "key_points" [{"name", "at_m"}], "deformations" [name], "bodies" [{"name", "centre_m"}] (parts and
/// volumes of air between which heat flows) and "flows" [{"name", "kind" (of the contact or film), "from", "to",
/// "outside" (whether `to` is a surrounding), "at_m"}]}, in the order of the state's numbers; places are [r, z] in m.
/// Allocates.
std::string scene_json(const rom::Network& network, const std::string& notice, bool has_history);

}  // namespace spindle_twin::firmware
