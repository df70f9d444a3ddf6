#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// Stands still unless it is set, from any thread; counts how often it was asked.
class StandingClock final : public Clock {
 public:
  std::int64_t now_ns() const override {
    ++asked;
    return now_;
  }
  void sleep_until_ns(std::int64_t time_ns) override { now_ = time_ns; }
  void pass(std::int64_t by_ns) { now_ += by_ns; }

  mutable std::atomic<long> asked{0};

 private:
  std::atomic<std::int64_t> now_{1000 * ns_per_s};
};

}  // namespace spindle_twin::firmware
