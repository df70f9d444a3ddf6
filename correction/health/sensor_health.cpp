#include "correction/health/sensor_health.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spindle_twin::correction {
namespace {

constexpr int outliers_to_fail = 3;
constexpr int electrical_to_fail = 2;
constexpr double absent_restart_s = 30.0;  // after such a gap a course is unknown, or after so many intervals
constexpr double absent_intervals = 5.0;
constexpr double old_course_memory_s = 120.0;
constexpr double rate_memory_s = 600.0;
constexpr double never_s = -1e18;

}  // namespace

SensorHealth::SensorHealth(std::vector<HealthChannel> channels, const HealthLimits& limits)
    : channels_(std::move(channels)), limits_(limits), states_(channels_.size()), records_(channels_.size()) {
  const auto n = static_cast<Eigen::Index>(channels_.size());
  product_K2_ = Eigen::MatrixXd::Zero(n, n);
  reading_square_K2_ = model_square_K2_ = Eigen::VectorXd::Zero(n);
  for (Channel& channel : states_) channel.spike_times_s.fill(never_s);
}

bool SensorHealth::present(std::size_t i, const HealthSample& sample) const {
  return channels_[i].configured && sample.present && std::isfinite(sample.reading_K);
}

bool SensorHealth::in_use(std::size_t i) const {
  return records_[i].state == HealthState::good || records_[i].state == HealthState::suspect;
}

void SensorHealth::change(std::size_t i, HealthState state) {
  if (records_[i].state == state) return;
  records_[i].state = state;
  records_[i].since_s = time_s_;
}

void SensorHealth::fail(std::size_t i, HealthFault fault, bool latch) {
  Channel& channel = states_[i];
  HealthRecord& record = records_[i];
  record.fault = fault;
  record.usable = false;
  channel.quiet_s = 0.0;
  channel.outliers = 0;
  channel.course.restart();
  channel.has_last_e = false;
  if (in_use(i)) ++record.failures;
  channel.latched = channel.latched || latch || record.failures >= limits_.failures;
  change(i, HealthState::failed);
}

void SensorHealth::fail_swapped(std::size_t i, std::size_t j) {
  fail(i, HealthFault::swapped, true);
  fail(j, HealthFault::swapped, true);
  records_[i].partner = static_cast<int>(j);
  records_[j].partner = static_cast<int>(i);
}

HealthFault SensorHealth::electrical(std::size_t i, double reading_K) const {
  if (reading_K >= limits_.open_above_K) return HealthFault::open;
  if (reading_K <= limits_.short_below_K) return HealthFault::shorted;
  if (reading_K < channels_[i].min_K || reading_K > channels_[i].max_K) return HealthFault::out_of_range;
  return HealthFault::none;
}

/// True where the sample is to be looked at further.
bool SensorHealth::judge_electrical(std::size_t i, const HealthSample& sample, double h_s) {
  Channel& channel = states_[i];
  HealthRecord& record = records_[i];
  record.usable = record.returned = false;
  channel.outlying = false;
  channel.model_K += sample.moved_K;
  channel.still_K += sample.moved_K + channel.e_rate_K_per_s * h_s;
  channel.elapsed_s += h_s;
  channel.moved_K += sample.moved_K;
  if (!present(i, sample)) return false;
  if (channel.elapsed_s > std::max(absent_restart_s, absent_intervals * channels_[i].interval_s)) {
    channel.course.restart();
    channel.standstill.restart();
    channel.has_last_e = false;
  }
  channel.course.advance(channel.moved_K, channel.elapsed_s, limits_);
  const HealthFault fault = electrical(i, sample.reading_K);
  if (fault == HealthFault::none) {
    if (channel.electrical > 0 && in_use(i)) note_spike(i);
    channel.electrical = 0;
    return true;
  }
  if (++channel.electrical >= electrical_to_fail) {
    fail(i, fault, false);
  } else if (in_use(i)) {
    record.fault = fault;
    change(i, HealthState::suspect);
  }
  channel.quiet_s = 0.0;
  return false;
}

void SensorHealth::note_spike(std::size_t i) {
  Channel& channel = states_[i];
  ++records_[i].spikes;
  const auto room = static_cast<int>(channel.spike_times_s.size());
  channel.spike_times_s[static_cast<std::size_t>(channel.spike_at)] = time_s_;
  channel.spike_at = (channel.spike_at + 1) % room;
  const auto recent = std::count_if(channel.spike_times_s.begin(), channel.spike_times_s.end(),
                                    [&](double at_s) { return time_s_ - at_s <= limits_.spike_window_s; });
  if (recent >= std::min(limits_.spikes, room)) {
    channel.spike_times_s.fill(never_s);
    fail(i, HealthFault::spikes, false);
  }
}

bool SensorHealth::exchanged_courses(std::size_t i, std::size_t j) const {
  const Channel& a = states_[i];
  const Channel& b = states_[j];
  // The reading of i on the course of j: r_i = e_i + u_i against ê_j + u_j.
  const double i_on_j_K = a.e_K + a.model_K - b.course.expected_K - b.model_K;
  const double j_on_i_K = b.e_K + b.model_K - a.course.expected_K - a.model_K;
  return std::abs(i_on_j_K) <= b.course.limit_K && std::abs(j_on_i_K) <= a.course.limit_K;
}

double SensorHealth::left_over_K2(std::size_t i, std::size_t j) const {
  const auto a = static_cast<Eigen::Index>(i);
  const auto b = static_cast<Eigen::Index>(j);
  return left_over(reading_square_K2_[a], product_K2_(a, b), model_square_K2_[b]);
}

bool SensorHealth::moves_without(std::size_t i, const HealthSample& sample) {
  Channel& channel = states_[i];
  const double free_K = std::isfinite(sample.uncorrected_K) ? sample.uncorrected_K : channel.model_K;
  return channel.standstill.observe(time_s_, sample.reading_K, {channel.model_K, channel.still_K, free_K},
                                    channels_[i].resolution_K, limits_);
}

void SensorHealth::find_outliers(const std::vector<HealthSample>& samples) {
  std::size_t judged = 0, outlying = 0;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = states_[i];
    if (!present(i, samples[i]) || channel.electrical > 0) continue;
    channel.e_K = samples[i].reading_K - channel.model_K;
    channel.outlying = channel.course.outlier(channel.e_K);
    if (!in_use(i)) continue;
    ++judged;
    if (channel.outlying) ++outlying;
  }
  model_in_doubt_ = outlying >= 3 && 2 * outlying > judged;
  if (!model_in_doubt_) return;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = states_[i];
    if (!in_use(i) || !channel.outlying) continue;
    channel.outlying = false;
    channel.outliers = 0;
    channel.course.restart();
    channel.course.accept(channel.e_K, channel.elapsed_s, channels_[i].noise_K);
  }
}

void SensorHealth::find_swapped(const std::vector<HealthSample>& samples, double h_s) {
  const double weight = 1.0 - std::exp(-h_s / limits_.swap_window_s);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = states_[i];
    if (std::isfinite(samples[i].uncorrected_K)) {
      channel.m_K = channel.model_movement.pass(samples[i].uncorrected_K, h_s, limits_.swap_window_s);
    }
    if (present(i, samples[i]) && channel.electrical == 0 && !channel.outlying) {
      channel.y_K = channel.reading_movement.pass(samples[i].reading_K, channel.elapsed_s, limits_.swap_window_s);
    }
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const double y_K = states_[i].y_K, m_K = states_[i].m_K;
    reading_square_K2_[a] += weight * (y_K * y_K - reading_square_K2_[a]);
    model_square_K2_[a] += weight * (m_K * m_K - model_square_K2_[a]);
    for (std::size_t j = 0; j < channels_.size(); ++j) {
      double& product_K2 = product_K2_(a, static_cast<Eigen::Index>(j));
      product_K2 += weight * (y_K * states_[j].m_K - product_K2);
    }
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    for (std::size_t j = i + 1; j < channels_.size(); ++j) {
      if (!in_use(i) || !in_use(j) || !channels_[i].configured || !channels_[j].configured) continue;
      const bool by_course = states_[i].outlying && states_[j].outlying && exchanged_courses(i, j) &&
                             std::max(states_[i].outliers, states_[j].outliers) + 1 >= outliers_to_fail;
      const bool by_movement =
          fits_swapped(left_over_K2(i, i), left_over_K2(j, j), left_over_K2(i, j), left_over_K2(j, i), limits_);
      if (!by_course && !by_movement) continue;
      fail_swapped(i, j);
    }
  }
}

/// A channel in use whose reading is electrically right.
void SensorHealth::settle(std::size_t i, const HealthSample& sample, double h_s) {
  Channel& channel = states_[i];
  HealthRecord& record = records_[i];
  if (channel.outlying) {
    if (channel.outliers == 0) {
      channel.first_outlier_K = channel.e_K;
      channel.first_miss_K = channel.e_K - channel.course.expected_K;
    }
    if (++channel.outliers >= outliers_to_fail) {
      // A jump stays where it went; what goes on in the same direction is the place, warming faster than the model.
      const double since_K = channel.e_K - channel.first_outlier_K;
      if (since_K * channel.first_miss_K > 0.0 && std::abs(since_K) > 0.5 * std::abs(channel.first_miss_K)) {
        channel.outliers = 0;
        channel.course.restart();
        channel.course.accept(channel.e_K, h_s, channels_[i].noise_K);
        return;
      }
      fail(i, HealthFault::jump, false);
    } else {
      record.fault = HealthFault::jump;
      change(i, HealthState::suspect);
    }
    return;
  }
  if (channel.outliers > 0) {
    channel.outliers = 0;
    note_spike(i);
    if (!in_use(i)) return;
  }
  channel.course.accept(channel.e_K, h_s, channels_[i].noise_K);
  if (moves_without(i, sample)) {
    fail(i, HealthFault::stuck, false);
    return;
  }
  if (channel.standstill.repeats()) {
    record.fault = HealthFault::stuck;
    change(i, HealthState::suspect);
    channel.has_last_e = false;
    return;
  }
  if (channel.has_last_e && h_s > 0.0) {
    const double rate_K_per_s = (channel.e_K - channel.last_e_K) / h_s;
    channel.e_rate_K_per_s += (1.0 - std::exp(-h_s / rate_memory_s)) * (rate_K_per_s - channel.e_rate_K_per_s);
  }
  channel.last_e_K = channel.e_K;
  channel.has_last_e = true;
  record.fault = HealthFault::none;
  record.usable = true;
  change(i, HealthState::good);
  const double off_K = sample.reading_K - sample.predicted_K;
  const double weight = channel.has_old_course ? 1.0 - std::exp(-h_s / old_course_memory_s) : 1.0;
  channel.old_course_K += weight * (off_K - channel.old_course_K);
  channel.has_old_course = true;
}

void SensorHealth::follow_return(std::size_t i, const HealthSample& sample, double h_s) {
  Channel& channel = states_[i];
  HealthRecord& record = records_[i];
  const bool stuck = moves_without(i, sample);
  // A stuck channel shows nothing but its old value until it moves.
  const bool still = stuck || (record.fault == HealthFault::stuck && channel.standstill.repeats());
  const double off_K = channel.has_old_course ? sample.reading_K - sample.predicted_K - channel.old_course_K : 0.0;
  const double within_K = record.fault == HealthFault::implausible ? std::min(limits_.jump_K, limits_.return_within_K)
                                                                   : limits_.return_within_K;
  if (channel.outlying || still || std::abs(off_K) > within_K) {
    channel.quiet_s = 0.0;
    if (channel.outlying) channel.course.restart();
    change(i, HealthState::failed);
  } else {
    channel.quiet_s += h_s;
  }
  channel.course.accept(channel.e_K, h_s, channels_[i].noise_K);
  if (channel.latched || channel.quiet_s <= 0.0) return;
  if (channel.quiet_s < limits_.return_after_s) {
    change(i, HealthState::returning);
    return;
  }
  record.returned = record.usable = true;
  record.return_offset_K = limits_.return_offset_K + std::abs(off_K);
  record.fault = HealthFault::none;
  record.partner = -1;
  channel.has_old_course = false;
  channel.old_course_K = 0.0;
  change(i, HealthState::good);
}

void SensorHealth::step(const std::vector<HealthSample>& samples, double time_s, double h_s) {
  time_s_ = time_s;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!judge_electrical(i, samples[i], h_s)) states_[i].e_K = states_[i].course.expected_K;
  }
  find_outliers(samples);
  find_swapped(samples, h_s);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!present(i, samples[i])) continue;
    const double elapsed_s = states_[i].elapsed_s;
    states_[i].elapsed_s = states_[i].moved_K = 0.0;
    if (states_[i].electrical > 0) continue;
    if (in_use(i)) {
      settle(i, samples[i], elapsed_s);
    } else {
      follow_return(i, samples[i], elapsed_s);
    }
  }
}

int SensorHealth::exchanged_with(std::size_t w, const std::vector<HealthUpdate>& updates) const {
  int partner = -1;
  double least = limits_.exchange_share;
  if (time_s_ - states_[w].calm_s > limits_.exchange_s) return partner;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (i == w || !channels_[i].configured || !in_use(i) || !updates[i].taken) continue;
    if (updates[i].evidence < limits_.exchange_evidence) continue;
    const double left = left_when_exchanged(updates[w].reading_K, updates[w].misfit_K, updates[i].reading_K,
                                            updates[i].misfit_K, limits_);
    if (left >= least) continue;
    least = left;
    partner = static_cast<int>(i);
  }
  return partner;
}

HealthVerdict SensorHealth::note_update(const std::vector<HealthUpdate>& updates) {
  int judged = 0, worst = -1;
  double most = 0.0, next = 0.0;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!channels_[i].configured || !in_use(i) || !updates[i].taken) continue;
    ++judged;
    const double evidence = updates[i].evidence;
    if (evidence <= limits_.exchange_evidence) states_[i].calm_s = time_s_;
    next = std::max(next, std::min(most, evidence));
    if (evidence <= most) continue;
    most = evidence;
    worst = static_cast<int>(i);
  }
  if (judged < 3 || most <= limits_.drift_limit || time_s_ < drift_wait_s_) return {};
  const auto w = static_cast<std::size_t>(worst);
  const int partner = judged > 3 ? exchanged_with(w, updates) : -1;
  if (partner < 0 && most - next < limits_.drift_lead) return {};
  drift_wait_s_ = time_s_ + limits_.drift_wait_s;
  if (partner >= 0) {
    fail_swapped(w, static_cast<std::size_t>(partner));
  } else {
    const bool drifts = updates[w].rejected_in_a_row < limits_.rejected;
    fail(w, drifts ? HealthFault::drift : HealthFault::implausible, drifts);
  }
  return {worst, partner};
}

void SensorHealth::acknowledge() {
  for (Channel& channel : states_) channel.latched = false;
  for (HealthRecord& record : records_) record.failures = 0;
}

}  // namespace spindle_twin::correction
