#include "firmware/keep/event_log.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

template <class Codes>
const char* name_of(const Codes& codes, std::uint16_t value) {
  const auto found = std::find_if(codes.begin(), codes.end(), [&](const auto& code) { return code.value == value; });
  return found == codes.end() ? "unknown" : found->name;
}

/// Names of the bits that are set.
template <class Codes>
std::string names_of(const Codes& codes, std::uint16_t bits) {
  std::string names;
  for (const auto& code : codes) {
    if ((bits & code.value) != 0) names.append(names.empty() ? "" : ", ").append(code.name);
  }
  return names.empty() ? "none" : names;
}

}  // namespace

EventLog::EventLog(const rom::Network& network) {
  for (const rom::KeyPoint& point : network.key_points) key_points_.push_back(point.name);
}

void EventLog::run(const std::atomic<bool>& stop) {
  Snapshot snapshot;
  while (true) {
    const bool last = stop.load(std::memory_order_acquire);
    if (tap_.read(snapshot)) note(snapshot, MonotonicClock().now_ns());
    const std::int64_t before_ns = MonotonicClock().now_ns();
    const double unix_s = unix_now_s();
    const std::int64_t now_ns = MonotonicClock().now_ns();
    if (now_ns - before_ns < ns_per_s / 10) note_clock(unix_s, now_ns);  // else this thread stood still between them
    if (last) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void EventLog::note_clock(double unix_s, std::int64_t now_ns) {
  constexpr double least_s = 1.0;
  const double offset_s = unix_s - 1e-9 * static_cast<double>(now_ns);
  const double moved_s = offset_s - clock_offset_s_.value_or(offset_s);
  if (clock_offset_s_ && std::abs(moved_s) < least_s) return;
  const bool first = !clock_offset_s_;
  clock_offset_s_ = offset_s;
  if (first) return;
  const auto held_back = clock_.pass(now_ns);
  if (!held_back) return;
  spdlog::warn(
      "the clock on the wall was set {} by {:.0f} s: times of the log and of histories jump, no prediction does{}",
      moved_s > 0.0 ? "forward" : "back", std::abs(moved_s), LogLimit::also(*held_back));
}

void EventLog::note(const Snapshot& snapshot, std::int64_t now_ns) {
  note_state(snapshot, now_ns);
  note_faults(snapshot, now_ns);
  note_sensors(snapshot, now_ns);
  note_orders(snapshot, now_ns);
  note_overruns(snapshot, now_ns);
  note_trial(snapshot, now_ns);
  before_ = snapshot;
  first_ = false;
}

void EventLog::note_state(const Snapshot& now, std::int64_t now_ns) {
  if (!first_ && now.state == before_.state) return;
  const auto held_back = states_.pass(now_ns);
  if (!held_back) return;
  spdlog::info("state {}, quality: {}{}", name_of(state_codes, bits(now.state)), names_of(quality_codes, now.quality),
               LogLimit::also(*held_back));
}

void EventLog::note_faults(const Snapshot& now, std::int64_t now_ns) {
  const auto came = static_cast<std::uint16_t>(now.fault & ~before_.fault);
  const auto went = static_cast<std::uint16_t>(before_.fault & ~now.fault);
  if (came == 0 && went == 0) return;
  const auto held_back = faults_.pass(now_ns);
  if (!held_back) return;
  if (came != 0) spdlog::warn("fault {}{}", names_of(fault_codes, came), LogLimit::also(*held_back));
  if (went != 0) spdlog::info("fault {} is over{}", names_of(fault_codes, went), LogLimit::also(*held_back));
}

void EventLog::note_sensors(const Snapshot& now, std::int64_t now_ns) {
  const auto is_out = [](const SensorHealthState& health) {
    return health.state == SensorState::failed || health.state == SensorState::returning;
  };
  for (std::size_t k = 0; k < key_points_.size(); ++k) {
    const SensorHealthState& health = now.sensor_health[k];
    const bool failed = health.state == SensorState::failed && before_.sensor_health[k].state != SensorState::failed;
    const bool back = !is_out(health) && is_out(before_.sensor_health[k]);
    if (!failed && !back) continue;
    const auto held_back = sensors_.pass(now_ns);
    if (!held_back) continue;
    if (failed) {
      const auto partner = static_cast<std::size_t>(health.partner);  // -1, none: beyond all
      const bool has_partner = health.fault == SensorFault::swapped && partner < key_points_.size();
      spdlog::warn("sensor {}: failed, {}{}{}", key_points_[k], name_of(sensor_fault_codes, bits(health.fault)),
                   has_partner ? " with " + key_points_[partner] : "", LogLimit::also(*held_back));
    } else {
      spdlog::info("sensor {}: believed again{}", key_points_[k], LogLimit::also(*held_back));
    }
  }
}

void EventLog::note_orders(const Snapshot& now, std::int64_t now_ns) {
  for (std::size_t i = order_records; i-- > 0;) {  // the oldest first
    const OrderRecord& order = now.last_orders[i];
    if (order.number == 0 || order.result == OrderResult::waiting) continue;
    const bool said = std::any_of(told_.begin(), told_.end(), [&](const OrderRecord& each) {
      return each.number == order.number && each.result == order.result;
    });
    if (said) continue;
    const auto held_back = orders_.pass(now_ns);
    if (!held_back) continue;
    spdlog::info("order {} (the PLC's {}), {}: {}{}", order.number, order.id,
                 name_of(order_kind_codes, bits(order.kind)), name_of(order_result_codes, bits(order.result)),
                 LogLimit::also(*held_back));
  }
  told_ = now.last_orders;
}

void EventLog::note_overruns(const Snapshot& now, std::int64_t now_ns) {
  if (first_ || now.overruns == before_.overruns) return;
  const auto held_back = overruns_.pass(now_ns);
  if (!held_back) return;
  spdlog::warn("{} cycles missed, {} since the start{}", now.overruns - before_.overruns, now.overruns,
               LogLimit::also(*held_back));
}

void EventLog::note_trial(const Snapshot& now, std::int64_t now_ns) {
  const bool tries = now.compensation.trial_left_s > 0.0, tried = before_.compensation.trial_left_s > 0.0;
  if (tries == tried) return;
  const auto held_back = trials_.pass(now_ns);
  if (!held_back) return;
  spdlog::warn("compensation: {}{}",
               tries ? "a trial has begun, the value is no prediction" : "the trial has ended, the value goes back",
               LogLimit::also(*held_back));
}

}  // namespace spindle_twin::firmware
