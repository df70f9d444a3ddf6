#pragma once

#include <string>

#include "firmware/cycle/compensate.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// What of a scene the network does not say.
struct SceneSettings {
  std::string notice;          ///< what its reader is to know first: that it is simulated
  bool has_history = false;    ///< whether there are hours and days to ask for
  std::string network_sha256;  ///< of the network's file, hex
  CompensationPlan compensation;
};

/// What of a spindle does not change while its network runs, for the pages: {"notice", "has_history", "outlines"
/// [{"part", "points_m"}], "key_points" [{"name", "at_m"}], "deformations" [name], "bodies" [{"name", "centre_m"}]
/// (parts and volumes of air between which heat flows), "flows" [{"name", "kind" (of the contact or film), "from",
/// "to", "outside" (whether `to` is a surrounding), "at_m"}], in the order of the state's numbers, "network" {"sha256",
/// "cases" (of its certificate, 0: it has none), "worst_K", "worst_nose_um"}, "compensation" {"sign", "limit_um" (null:
/// none), "slew_um_per_s", "step_um"}}; places are [r, z] in m. Allocates.
std::string scene_json(const rom::Network& network, const SceneSettings& settings);

}  // namespace spindle_twin::firmware
