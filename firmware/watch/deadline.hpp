#pragma once

#include <cstdint>

namespace spindle_twin::firmware {

/// Absolute deadlines start + k·period. A cycle that comes a whole period or more late skips what it missed, so that
/// the model's time keeps up with the clock; the caller counts what take() returns.
class Deadline {
 public:
  Deadline(std::int64_t start_ns, std::int64_t period_ns) : due_ns_(start_ns), period_ns_(period_ns) {}

  std::int64_t due_ns() const { return due_ns_; }

  /// The cycle that was due runs at now_ns >= due_ns(): moves to the next deadline after the missed ones and returns
  /// how many whole periods were missed.
  std::int64_t take(std::int64_t now_ns) {
    const std::int64_t late_ns = now_ns - due_ns_;
    const std::int64_t missed = late_ns > 0 ? late_ns / period_ns_ : 0;
    due_ns_ += (missed + 1) * period_ns_;
    return missed;
  }

 private:
  std::int64_t due_ns_;
  std::int64_t period_ns_;
};

}  // namespace spindle_twin::firmware
