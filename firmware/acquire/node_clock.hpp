#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace spindle_twin::firmware {

/// When a node made its frames, by our clock. A node's clock has a start of its own and drifts; a frame takes a while
/// to come. The least difference between arrival and the node's time over the last 10 to 20 s counts as its clock's
/// offset, so that a frame that was held up on the way is as old as it is, and drift, restart or sleep of the node's
/// clock are forgotten within 20 s.
class NodeClock {
 public:
  /// Monotonic, not after received_ns. `time_ms` wraps.
  std::int64_t made_ns(std::uint32_t time_ms, std::int64_t received_ns) {
    node_ms_ += known_ ? static_cast<std::int32_t>(time_ms - last_ms_) : 0;
    last_ms_ = time_ms;
    if (!known_ || received_ns - began_ns_ >= window_ns) {
      least_before_ns_ = known_ && received_ns - began_ns_ < 2 * window_ns ? least_ns_ : none;
      least_ns_ = none;
      began_ns_ = received_ns;
      known_ = true;
    }
    constexpr std::int64_t ns_per_ms = 1'000'000;
    const std::int64_t node_ns = node_ms_ * ns_per_ms;
    least_ns_ = std::min(least_ns_, received_ns - node_ns);
    return node_ns + std::min(least_ns_, least_before_ns_);
  }

 private:
  static constexpr std::int64_t window_ns = 10'000'000'000;
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  bool known_ = false;
  std::uint32_t last_ms_ = 0;
  std::int64_t node_ms_ = 0;
  std::int64_t began_ns_ = 0;
  std::int64_t least_ns_ = none;
  std::int64_t least_before_ns_ = none;
};

}  // namespace spindle_twin::firmware
