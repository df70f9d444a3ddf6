#pragma once

#include <atomic>
#include <cstdint>

namespace spindle_twin::firmware {

/// What the cycle's thread shows of itself to who watches it; it only writes, and nothing makes it wait.
struct Pulse {
  std::atomic<std::uint64_t> cycles{0};  ///< made since the start
  std::atomic<bool> predicts{false};     ///< the last one had a prediction
  std::atomic<bool> waits{false};        ///< the last one has waited for a first reading for too long
};

}  // namespace spindle_twin::firmware
