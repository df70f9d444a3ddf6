#include "correction/health/isolation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::correction {
namespace {

constexpr double never_s = -1e18;

}  // namespace

Isolation::Isolation(std::size_t channels) : calm_s_(channels, 0.0), wait_until_s_(never_s) {}

double Isolation::left_when_exchanged(const HealthUpdate& one, const HealthUpdate& other, const HealthLimits& limits) {
  const double one_K = std::abs(one.misfit_K), other_K = std::abs(other.misfit_K);
  const bool alike = one.misfit_K * other.misfit_K < 0.0 &&
                     std::min(one_K, other_K) > limits.exchange_alike * std::max(one_K, other_K);
  if (!alike) return std::numeric_limits<double>::infinity();
  const double one_there_K = std::abs(one.reading_K - other.reading_K + other.misfit_K);
  const double other_there_K = std::abs(other.reading_K - one.reading_K + one.misfit_K);
  return (one_there_K + other_there_K) / (one_K + other_K);
}

int Isolation::partner_of(std::size_t channel, const std::vector<HealthUpdate>& updates, double time_s,
                          const HealthLimits& limits) const {
  int partner = -1;
  double least = limits.exchange_share;
  if (time_s - calm_s_[channel] > limits.exchange_s) return partner;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (i == channel || !updates[i].taken || updates[i].evidence < limits.exchange_evidence) continue;
    const double left = left_when_exchanged(updates[channel], updates[i], limits);
    if (left >= least) continue;
    least = left;
    partner = static_cast<int>(i);
  }
  return partner;
}

Blame Isolation::judge(const std::vector<HealthUpdate>& updates, double time_s, const HealthLimits& limits) {
  int judged = 0, worst = -1;
  double most = 0.0, next = 0.0;
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (!updates[i].taken) continue;
    ++judged;
    const double evidence = updates[i].evidence;
    if (evidence <= limits.exchange_evidence) calm_s_[i] = time_s;
    next = std::max(next, std::min(most, evidence));
    if (evidence <= most) continue;
    most = evidence;
    worst = static_cast<int>(i);
  }
  if (judged < 3 || most <= limits.drift_limit || time_s < wait_until_s_) return {};
  const auto blamed = static_cast<std::size_t>(worst);
  const int partner = judged > 3 ? partner_of(blamed, updates, time_s, limits) : -1;
  if (partner < 0 && most - next < limits.drift_lead) return {};
  wait_until_s_ = time_s + limits.drift_wait_s;
  if (partner >= 0) return {worst, partner, HealthFault::swapped};
  const bool drifts = updates[blamed].rejected_in_a_row < limits.rejected;
  return {worst, -1, drifts ? HealthFault::drift : HealthFault::implausible};
}

}  // namespace spindle_twin::correction
