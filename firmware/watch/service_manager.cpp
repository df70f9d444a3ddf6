#include "firmware/watch/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace spindle_twin::firmware {
namespace {

constexpr double cycles_missed = 3.0;     // until the watchdog may bite
constexpr double looks_a_watchdog = 4.0;  // sd_watchdog_enabled(3) asks for two at least
constexpr double rarest_look_s = 0.1;     // the end of the daemon waits for this thread so long at most
constexpr double start_extension_s = 30.0;

std::string microseconds(double seconds) { return std::to_string(std::llround(1e6 * seconds)); }

double asked_for_s() {
  std::uint64_t watchdog_us = 0;
  return sd_watchdog_enabled(0, &watchdog_us) > 0 ? 1e-6 * static_cast<double>(watchdog_us) : 0.0;
}

}  // namespace

ServiceManager::ServiceManager(const std::vector<const Pulse*>& pulses, double cycle_s, double watchdog_s,
                               Notify notify)
    : notify_(std::move(notify)),
      cycle_s_(cycle_s),
      watchdog_s_(watchdog_s > 0.0 ? std::max(watchdog_s, cycles_missed * cycle_s) : 0.0),
      look_s_(watchdog_s > 0.0 ? std::min(rarest_look_s, watchdog_s / looks_a_watchdog) : rarest_look_s) {
  for (const Pulse* pulse : pulses) spindles_.push_back({pulse});
  if (watchdog_s_ > watchdog_s) notify_("WATCHDOG_USEC=" + microseconds(watchdog_s_));
}

ServiceManager::ServiceManager(const std::vector<const Pulse*>& pulses, double cycle_s)
    : ServiceManager(pulses, cycle_s, asked_for_s(), [](const std::string& state) { sd_notify(0, state.c_str()); }) {}

/// Whether each has made a cycle since this last said so.
bool ServiceManager::all_beat() {
  for (Watched& each : spindles_) {
    const std::uint64_t cycles = each.pulse->cycles.load(std::memory_order_acquire);
    if (cycles != std::exchange(each.seen, cycles)) each.beats = true;
  }
  if (!std::all_of(spindles_.begin(), spindles_.end(), [](const Watched& each) { return each.beats; })) return false;
  for (Watched& each : spindles_) each.beats = false;
  return true;
}

void ServiceManager::look() {
  if (!all_beat()) return;
  bool waits = false;   // one of them
  bool settled = true;  // each of them predicts or waits
  for (const Watched& each : spindles_) {
    const bool this_waits = each.pulse->waits.load(std::memory_order_relaxed);
    waits = waits || this_waits;
    settled = settled && (this_waits || each.pulse->predicts.load(std::memory_order_relaxed));
  }
  if (!ready_ && !settled) {
    notify_("EXTEND_TIMEOUT_USEC=" + microseconds(start_extension_s + cycle_s_) +
            "\nSTATUS=waits for the first good readings");
    return;
  }
  if (!ready_ || waits != told_) {
    const std::string status = waits ? "STATUS=no good reading to start from, see the registers" : "STATUS=predicts";
    notify_(ready_ ? status : "READY=1\n" + status);
    ready_ = true;
    told_ = waits;
  }
  if (watchdog_s_ > 0.0) notify_("WATCHDOG=1");
}

void ServiceManager::run(const std::atomic<bool>& stop) {
  while (!stop.load()) {
    look();
    std::this_thread::sleep_for(std::chrono::duration<double>(look_s_));
  }
}

}  // namespace spindle_twin::firmware
