#pragma once

#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/register_map.hpp"

namespace spindle_twin::firmware {

/// Writes all registers but the command block from one snapshot; now_ns (monotonic) gives the prediction's age.
/// A value that had to be clipped raises Quality::saturated in the same image.
void fill_image(const Snapshot& snapshot, std::int64_t now_ns, RegisterImage& image);

}  // namespace spindle_twin::firmware
