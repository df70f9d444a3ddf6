#pragma once

#include <string>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// The heat flows of a cycle in W, as a member of the state, in the order of the scene's flows and bodies; null before
/// the first prediction:
///   "heat":{"flow_W":[12.5,...],"made_W":[60.0,...]}
/// What a body stores is what it is given (made_W) less its flows to others, and those that come. Allocates.
std::string flows_json(const Snapshot& snapshot);

}  // namespace spindle_twin::firmware
