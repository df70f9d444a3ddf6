#pragma once

#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "fem_offline/mesh/section.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// The section's outlines as a network file carries them, part by part, holes after their outer ring.
std::vector<rom::OutlineRing> section_outlines(const Spindle& spindle, const Section& section);

}  // namespace spindle_twin::fem_offline
