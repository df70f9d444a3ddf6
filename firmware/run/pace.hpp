#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace spindle_twin::firmware {

/// The pace of a page that reads a history: for five seconds at most, and it rests as long as it worked. Under a real-
/// time priority of the whole process nothing else would let the cycle in.
class Pace {
 public:
  explicit Pace(const std::atomic<bool>& stop) : stop_(stop) {}
  /// Rests; false when the time is over or `stop` is set.
  bool go_on() {
    const auto now = std::chrono::steady_clock::now();
    if (now >= end_) return false;
    std::this_thread::sleep_for(std::min(now - began_, end_ - now));
    began_ = std::chrono::steady_clock::now();
    return began_ < end_ && !stop_.load(std::memory_order_acquire);
  }

 private:
  const std::atomic<bool>& stop_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point end_ = began_ + std::chrono::seconds(5);
};

}  // namespace spindle_twin::firmware
