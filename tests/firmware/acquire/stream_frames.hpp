#pragma once

#include <cstdint>
#include <vector>

extern "C" {
#include "firmware/example_node/node.h"
}

namespace spindle_twin::firmware::frames {

/// One frame of the example node with these values on the channels 0, 1...; its sequence is one more than the last.
inline std::vector<std::uint8_t> frame_of(node& sender, std::uint32_t time_ms, const std::vector<float>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) node_add(&sender, static_cast<std::uint32_t>(i), values[i], 0);
  std::vector<std::uint8_t> frame(NODE_FRAME_ROOM);
  frame.resize(node_frame(&sender, time_ms, frame.data()));
  return frame;
}

}  // namespace spindle_twin::firmware::frames
