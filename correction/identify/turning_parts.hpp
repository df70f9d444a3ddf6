#pragma once

#include <string>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Parts of a network that turn with the shaft, as far as it shows: the parts into which the largest share of a
/// friction heat goes, its balls or rollers, and all that is joined by contacts, without them, to the part nearest the
/// axis. Where that would be the outermost part too, the balls alone: then it does not show. In the network's order.
std::vector<std::string> turning_parts(const rom::Network& network);

}  // namespace spindle_twin::correction
