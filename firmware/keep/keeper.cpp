#include "firmware/keep/keeper.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/parameters.hpp"
#include "firmware/keep/state_files.hpp"
#include "firmware/watch/clock.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

/// Empty where it fits.
std::string objection(const Checkpoint& checkpoint, const KeepPlan& plan, const std::string& network_sha256,
                      double age_s) {
  if (checkpoint.network_sha256 != network_sha256) return "it is of another network";
  if (age_s < 0.0) return "it was written later than the clock says now";
  if (age_s > plan.max_age_s) {
    return fmt::format("it is {:.1f} h old, checkpoint.max_age_h is {:.1f}", age_s / rom::seconds_per_hour,
                       plan.max_age_s / rom::seconds_per_hour);
  }
  return {};
}

}  // namespace

std::optional<Checkpoint> look_for_checkpoint(const KeepPlan& plan) {
  const std::string& path = plan.checkpoint_path;
  if (path.empty()) return std::nullopt;
  try {
    std::optional<Checkpoint> checkpoint = read_checkpoint(path);
    if (!checkpoint) spdlog::info("checkpoint {}: there is none yet", path);
    return checkpoint;
  } catch (const rom::InputError& error) {
    spdlog::warn("checkpoint {}; not used, a cold start{}", error.what(), put_state_aside(path));
    return std::nullopt;
  }
}

Resumed resume_from_checkpoint(const KeepPlan& plan, const std::optional<Checkpoint>& checkpoint,
                               const StartingPoint& start, Cycle& cycle, const std::atomic<bool>* stop) {
  if (!checkpoint) return Resumed::nothing;
  const std::string& path = plan.checkpoint_path;
  const bool same_boot = !start.now.boot.empty() && checkpoint->saved.boot == start.now.boot;
  const double age_s = same_boot ? start.now.s - checkpoint->saved.s : start.now_unix_s - checkpoint->saved_unix_s;
  std::string reason = objection(*checkpoint, plan, start.network_sha256, age_s);
  const Resumed resumed =
      reason.empty() ? cycle.resume(checkpoint->remembered, age_s * start.clock_rate, stop) : Resumed::nothing;
  if (resumed == Resumed::given_up) return resumed;
  if (reason.empty() && resumed == Resumed::nothing) reason = "its sizes do not fit";
  if (resumed == Resumed::implausible) reason = "it has temperatures or tares that no spindle has";
  if (!reason.empty()) {
    const int known = resumed == Resumed::implausible ? 0 : cycle.begin_with_machine(checkpoint->remembered);
    const bool in_time = age_s >= 0.0 && age_s <= plan.max_age_s;
    std::string besides;
    if (known > 0) besides = fmt::format(", with what was known of {} parameters of the machine", known);
    if (known == 0 && in_time) besides = put_state_aside(path);
    spdlog::warn("checkpoint {}: not used, {}; a cold start{}", path, reason, besides);
  } else {
    spdlog::info("checkpoint {}: goes on from {:.0f} s ago, {}", path, age_s,
                 resumed == Resumed::temperatures ? "temperatures and tare only" : "with what the estimator knew");
  }
  return resumed;
}

Keeper::Keeper(KeepPlan plan, std::string network_sha256, double clock_rate, const Cycle& cycle,
               const OrderKeeper* orders, Troubles* troubles)
    : plan_(std::move(plan)),
      network_sha256_(std::move(network_sha256)),
      clock_rate_(clock_rate),
      orders_(orders),
      troubles_(troubles) {
  if (const correction::ParameterModel* parameters = cycle.parameters()) parameters_ = parameters->list();
  cycle.remember(remembered_.value);
}

std::chrono::steady_clock::time_point next_checkpoint(std::chrono::steady_clock::time_point due,
                                                      std::chrono::steady_clock::time_point now,
                                                      std::chrono::steady_clock::duration interval, bool kept) {
  constexpr std::chrono::seconds patience(1);
  const auto next = due + interval > now ? due + interval : now + interval;
  return kept ? next : std::min(next, now + patience);
}

bool Keeper::keep(bool say) {
  const Remembered& now = remembered_.value;
  if (!now.started) return true;
  bool kept = true;
  try {
    if (!plan_.checkpoint_path.empty()) {
      const std::uint32_t revision = orders_ != nullptr ? orders_->revision() : 0;
      const std::string& of = now.network_sha256.empty() ? network_sha256_ : now.network_sha256;
      write_checkpoint({of, unix_now_s(), now, revision, boot_now()}, plan_.checkpoint_path);
    }
    if (!plan_.parameters_path.empty() && !parameters_.empty()) {
      rom::write_whole_file(plan_.parameters_path, parameters_csv(parameters_, now.parameters));
    }
    if (troubles_ != nullptr) troubles_->set(Fault::checkpoint_lost, false);
  } catch (const rom::InputError& error) {
    kept = false;
    if (troubles_ != nullptr) troubles_->set(Fault::checkpoint_lost, true);
    const auto before = complaints_.pass(MonotonicClock().now_ns());
    if (before) spdlog::error("{}{}", error.what(), LogLimit::also(*before));
  }
  const std::string heats = unexplained_heats(parameters_, now.parameters);
  if (heats.empty() != heats_said_.empty()) {
    spdlog::info("after {:.0f} s {}", now.model_time_s, heats.empty() ? "the sources explain all heat again" : heats);
    heats_said_ = heats;
  }
  if (parameters_.empty() || (!say && now.model_time_s - said_at_s_ < rom::seconds_per_hour)) return kept;
  spdlog::info("after {:.0f} s {}", now.model_time_s, what_is_determined(parameters_, now.parameters));
  said_at_s_ = now.model_time_s;
  return kept;
}

void Keeper::run(const std::atomic<bool>& stop) {
  const auto interval = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(plan_.interval_s / clock_rate_));
  constexpr std::chrono::milliseconds slice(20);
  auto due = std::chrono::steady_clock::now() + interval;
  while (!stop.load(std::memory_order_acquire)) {
    std::this_thread::sleep_for(slice);
    if (!keep_now_.exchange(false, std::memory_order_acquire) && std::chrono::steady_clock::now() < due) continue;
    remembered_.ask();
    while (remembered_.asked() && !stop.load(std::memory_order_acquire)) std::this_thread::sleep_for(slice);
    const bool kept = remembered_.asked() || keep(false);
    due = next_checkpoint(due, std::chrono::steady_clock::now(), interval, kept);
  }
}

void Keeper::keep_last(const Cycle& cycle) {
  cycle.remember(remembered_.value);
  keep(true);
}

}  // namespace spindle_twin::firmware
