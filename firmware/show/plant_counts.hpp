#pragma once

#include <atomic>
#include <cstdint>

namespace spindle_twin::firmware {

/// What the plant network's thread has to say, for /metrics; of all spindles, since the start.
struct PlantCounts {
  std::atomic<std::uint64_t> published{0};  ///< samples that the broker has read
  std::atomic<std::uint64_t> dropped{0};    ///< samples that there was no room for
  std::atomic<std::uint64_t> waiting{0};    ///< samples in the queue now
  std::atomic<std::uint64_t> connected{0};  ///< 1 while the broker is there
};

}  // namespace spindle_twin::firmware
