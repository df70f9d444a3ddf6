#include "firmware/acquire/device_thread.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <exception>

namespace spindle_twin::firmware {

double back_off_s(const DevicePlan& plan, int losses) {
  return std::min(plan.retry_most_s, plan.retry_s * std::ldexp(1.0, std::min(losses, 30)));
}

DeviceThread::DeviceThread(const DevicePlan& plan, std::size_t number, Clock& clock, Latest<DeviceFrame>& frames)
    : plan_(plan),
      clock_(clock),
      frames_(frames),
      driver_(plan.driver->make_driver(clock)),
      readings_(plan.name, number, plan.channels, plan.delay_s) {}

void DeviceThread::sleep_until(std::int64_t time_ns, const std::atomic<bool>& stop) {
  while (!stop.load(std::memory_order_relaxed) && clock_.now_ns() < time_ns) {
    constexpr std::int64_t slice_ns = 100'000'000;
    clock_.sleep_until_ns(std::min(time_ns, clock_.now_ns() + slice_ns));
  }
}

Step DeviceThread::step() {
  try {
    return driver_->step(readings_);
  } catch (const std::exception& error) {
    return {Step::Is::lost, error.what()};
  }
}

/// One line per change and per new reason, of a device that comes and goes a few in a minute.
void DeviceThread::note(const Step& step) {
  const bool connected = step.is == Step::Is::fresh;
  readings_.set_connected(connected);
  frames_.write(readings_.frame());
  if (said_connected_ == connected && (connected || said_reason_ == step.reason)) return;
  const auto before = changes_.pass(clock_.now_ns());
  if (!before) return;
  said_connected_ = connected;
  said_reason_ = step.reason;
  if (connected) {
    spdlog::info("device {} at {} answers{}", plan_.name, plan_.driver->where(), LogLimit::also(*before));
  } else {
    spdlog::warn("device {} at {} does not answer ({}); trying on{}", plan_.name, plan_.driver->where(), step.reason,
                 LogLimit::also(*before));
  }
}

void DeviceThread::run(const std::atomic<bool>& stop) {
  const auto period_ns = static_cast<std::int64_t>(1e9 * plan_.poll_s);
  int losses = 0;
  std::int64_t due_ns = clock_.now_ns();
  while (!stop.load(std::memory_order_relaxed)) {
    const Step made = step();
    if (stop.load(std::memory_order_relaxed)) return;
    note(made);
    const std::int64_t now_ns = clock_.now_ns();
    if (made.is == Step::Is::lost) {
      due_ns = now_ns + static_cast<std::int64_t>(1e9 * back_off_s(plan_, losses++));
    } else {
      losses = 0;
      due_ns = std::max(due_ns + period_ns, now_ns);
    }
    sleep_until(due_ns, stop);
  }
}

}  // namespace spindle_twin::firmware
