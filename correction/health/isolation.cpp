#include "correction/health/isolation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/health/surprise.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double never_s = -1e18;
constexpr double offset_deviations = 3.0;  // of an untared sensor: a misfit within may be its offset

}  // namespace

Isolation::Isolation(std::size_t channels) : memories_(channels), wait_until_s_(never_s), first_until_s_(never_s) {}

void Isolation::note_restart(double time_s) {
  for (Memory& memory : memories_) memory = {time_s, 0.0, 0.0, memory.opened};
  restart_s_ = last_s_ = time_s;
  model_in_doubt_ = false;
}

void Isolation::acknowledge() {
  for (Memory& memory : memories_) memory.opened = false;
}

double Isolation::left_when_swapped(const HealthUpdate& one, const HealthUpdate& other, const HealthLimits& limits) {
  const double one_K = std::abs(one.misfit_K), other_K = std::abs(other.misfit_K);
  const bool alike =
      one.misfit_K * other.misfit_K < 0.0 && std::min(one_K, other_K) > limits.swap_alike * std::max(one_K, other_K);
  if (!alike) return std::numeric_limits<double>::infinity();
  const double one_there_K = std::abs(one.reading_K - other.reading_K + other.misfit_K);
  const double other_there_K = std::abs(other.reading_K - one.reading_K + one.misfit_K);
  return (one_there_K + other_there_K) / (one_K + other_K);
}

int Isolation::partner_of(std::size_t channel, const std::vector<HealthUpdate>& updates, double time_s,
                          const HealthLimits& limits) const {
  int partner = -1;
  double least = limits.swap_share;
  if (time_s - memories_[channel].calm_s > limits.swap_s) return partner;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (i == channel || !updates[i].taken || memories_[i].counted < limits.swap_evidence) continue;
    const double left = left_when_swapped(updates[channel], updates[i], limits);
    if (left >= least) continue;
    least = left;
    partner = static_cast<int>(i);
  }
  return partner;
}

void Isolation::count_evidence(const std::vector<HealthUpdate>& updates, double time_s, const HealthLimits& limits) {
  const bool settling = time_s - restart_s_ < limits.settle_s;
  const double fade = std::exp(-(time_s - last_s_) / evidence_memory_s);
  last_s_ = time_s;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    Memory& memory = memories_[i];
    if (!updates[i].taken) continue;
    const double evidence = std::max(0.0, updates[i].evidence);
    memory.counted = settling ? evidence : evidence - std::min(evidence, fade * memory.settled);
    memory.settled = settling ? evidence : std::min(evidence, fade * memory.settled);
    if (evidence <= limits.swap_evidence) memory.calm_s = time_s;
  }
}

bool Isolation::explains_alone(const std::vector<HealthUpdate>& updates, int channel, int partner) const {
  double own = 0.0, others = 0.0;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (!updates[i].taken) continue;
    const auto at = static_cast<int>(i);
    (at == channel || at == partner ? own : others) += memories_[i].counted;
  }
  return own > others;
}

bool Isolation::may_be_offset(int channel, double misfit_K, const HealthLimits& limits) const {
  return !memories_[static_cast<std::size_t>(channel)].opened &&
         std::abs(misfit_K) <= offset_deviations * limits.return_offset_deviation_K;
}

Blame Isolation::blame_drift(int channel, double misfit_K, const HealthLimits& limits) {
  if (!may_be_offset(channel, misfit_K, limits)) return {channel, -1, HealthFault::drift, model_in_doubt_};
  memories_[static_cast<std::size_t>(channel)].opened = true;
  return {channel, -1, HealthFault::none, model_in_doubt_, false, true};
}

Blame Isolation::judge_suspect(int channel, double misfit_K, double deviation_K, double time_s,
                               const HealthLimits& limits) {
  const bool is_off = std::abs(misfit_K) > limits.opinion_deviations * deviation_K;
  if (!is_off && !may_be_offset(channel, misfit_K, limits)) return {};
  wait_until_s_ = time_s + limits.drift_wait_s;
  return blame_drift(channel, misfit_K, limits);
}

Blame Isolation::judge(const std::vector<HealthUpdate>& updates, bool estimate_in_doubt, double time_s,
                       const HealthLimits& limits) {
  count_evidence(updates, time_s, limits);
  int judged = 0, doubtful = 0, worst = -1;
  double most = 0.0, next = 0.0;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (!updates[i].taken) continue;
    ++judged;
    const double evidence = memories_[i].counted;
    doubtful += evidence > limits.doubt_share * limits.drift_limit ? 1 : 0;
    next = std::max(next, std::min(most, evidence));
    if (evidence <= most) continue;
    most = evidence;
    worst = static_cast<int>(i);
  }
  const bool unlikely = most > limits.drift_limit && updates[static_cast<std::size_t>(worst)].is_unlikely_without;
  model_in_doubt_ = estimate_in_doubt || unlikely || (doubtful >= 2 && 2 * doubtful >= judged);
  if (judged < 3 || most <= limits.drift_limit || time_s < wait_until_s_) return {};
  const auto blamed = static_cast<std::size_t>(worst);
  const bool settling = time_s - restart_s_ < limits.settle_s;
  int partner = judged > 3 ? updates[blamed].moves_like : -1;
  if (partner < 0) {
    if (settling) return {};
    if (judged > 3) partner = partner_of(blamed, updates, time_s, limits);
    if (partner < 0 && most - next < limits.drift_lead) return {};
    if (model_in_doubt_ && !explains_alone(updates, worst, partner)) return {};
  }
  wait_until_s_ = time_s + limits.drift_wait_s;
  if (partner >= 0) return {worst, partner, HealthFault::swapped, model_in_doubt_};
  if (time_s > first_until_s_) {
    first_until_s_ = time_s + limits.second_opinion_s;
    model_in_doubt_ = true;
    return {worst, -1, HealthFault::none, true, true};
  }
  if (unlikely) return {};
  const bool rejected = updates[blamed].rejected_in_a_row >= limits.rejected;
  const bool fast = rejected || time_s - memories_[blamed].calm_s < limits.drift_least_s;
  if (fast) return {worst, -1, HealthFault::implausible, model_in_doubt_};
  return blame_drift(worst, updates[blamed].misfit_K, limits);
}

}  // namespace spindle_twin::correction
