#include "firmware/watch/keep_running.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <thread>

#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {
namespace {

/// Waits for `pause`, or until `stop` is set.
void rest(std::chrono::milliseconds pause, const std::atomic<bool>& stop) {
  constexpr std::chrono::milliseconds slice(20);
  for (; pause.count() > 0 && !stop.load(std::memory_order_acquire); pause -= slice) {
    std::this_thread::sleep_for(std::min(pause, slice));
  }
}

}  // namespace

void keep_running(const std::string& what, const std::atomic<bool>& stop, const std::function<void()>& work,
                  std::chrono::milliseconds pause) {
  LogLimit limit;
  do {
    try {
      return work();
    } catch (const std::exception& error) {
      const auto held_back = limit.pass(MonotonicClock().now_ns());
      if (held_back) spdlog::error("{} failed: {}; begins again{}", what, error.what(), LogLimit::also(*held_back));
    }
    rest(pause, stop);
  } while (!stop.load(std::memory_order_acquire));
}

}  // namespace spindle_twin::firmware
