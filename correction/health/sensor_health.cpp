#include "correction/health/sensor_health.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spindle_twin::correction {
namespace {

std::vector<double> noise_of(const std::vector<HealthChannel>& channels) {
  std::vector<double> noise_K;
  noise_K.reserve(channels.size());
  for (const HealthChannel& channel : channels) noise_K.push_back(channel.noise_K);
  return noise_K;
}

}  // namespace

SensorHealth::SensorHealth(const std::vector<HealthChannel>& channels, const HealthLimits& limits)
    : limits_(limits),
      swaps_(noise_of(channels)),
      isolation_(channels.size()),
      considered_(channels.size()),
      in_use_(channels.size()) {
  channels_.reserve(channels.size());
  for (const HealthChannel& channel : channels) channels_.emplace_back(channel, limits);
}

void SensorHealth::step(const std::vector<HealthSample>& samples, double time_s, double h_s) {
  time_s_ = time_s;
  for (std::size_t i = 0; i < channels_.size(); ++i) channels_[i].take(samples[i], time_s, h_s);
  follow_what_most_do();
  find_swapped(samples, h_s);
  for (Channel& channel : channels_) channel.judge();
}

/// When more than half of the channels, and three at least, leave their course with one sample, it is the spindle or
/// the model: all are followed.
void SensorHealth::follow_what_most_do() {
  int judged = 0, off_course = 0;
  for (const Channel& channel : channels_) {
    if (!channel.in_use() || !channel.reads()) continue;
    ++judged;
    off_course += channel.off_course() ? 1 : 0;
  }
  left_course_together_ = off_course >= 3 && 2 * off_course > judged;
  if (!left_course_together_) return;
  for (Channel& channel : channels_) {
    if (channel.in_use() && channel.off_course()) channel.follow_reading();
  }
}

void SensorHealth::fail_pair(std::size_t one, std::size_t other) {
  channels_[one].fail_swapped(static_cast<int>(other));
  channels_[other].fail_swapped(static_cast<int>(one));
}

void SensorHealth::begin_reading_for_each_other(std::size_t one, std::size_t other) {
  channels_[one].begin_reading_for_partner();
  channels_[other].begin_reading_for_partner();
}

void SensorHealth::heed_movement_of_swapped() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto other = static_cast<std::size_t>(std::max(record(i).partner, 0));
    const bool pair = other > i && channels_[i].is_swapped() && channels_[other].is_swapped();
    if (!pair || record(other).partner != static_cast<int>(i) || channels_[i].reads_for_partner()) continue;
    if (swaps_.evidence(i, other, limits_) > limits_.swap_limit) begin_reading_for_each_other(i, other);
  }
}

std::size_t SensorHealth::reader_of(std::size_t place) const {
  const int partner = record(place).partner;
  if (partner < 0) return place;
  const Channel& reader = channels_[static_cast<std::size_t>(partner)];
  const bool reads = reader.reads_for_partner() && reader.record().partner == static_cast<int>(place);
  return reads ? static_cast<std::size_t>(partner) : place;
}

template <class Contradicted>
HealthVerdict SensorHealth::end_reading_where(Contradicted&& is_contradicted) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const std::size_t reader = reader_of(i);
    const bool settled = time_s_ - record(i).since_s > limits_.settle_s;
    if (reader == i || !settled || !is_contradicted(i)) continue;
    channels_[i].end_reading_for_partner();
    channels_[reader].end_reading_for_partner();
    note_restart();
    return {static_cast<int>(i), static_cast<int>(reader)};
  }
  return {};
}

void SensorHealth::find_swapped(const std::vector<HealthSample>& samples, double h_s) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (std::isfinite(samples[i].uncorrected_K)) swaps_.note_model(i, samples[i].uncorrected_K, h_s);
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = channels_[i];
    in_use_[i] = channel.in_use();
    if (channel.was_away()) swaps_.forget(i);  // somebody may have swapped plugs
    if (!channel.reads() || channel.off_course()) continue;
    const bool counts = in_use_[i] || channel.is_swapped();
    swaps_.note_reading(i, samples[i].reading_K, channel.elapsed_s(), counts, limits_);
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    for (std::size_t j = i + 1; j < channels_.size(); ++j) {
      if (!in_use_[i] || !in_use_[j] || !channels_[i].swapped_courses_with(channels_[j])) continue;
      fail_crossed(i, j);
    }
  }
  find_replugged();
  const SwapDetector::Pair pair = swaps_.find(in_use_, limits_);
  if (pair.one >= 0) {
    fail_pair(static_cast<std::size_t>(pair.one), static_cast<std::size_t>(pair.other));
    untold_ = {pair.one, pair.other};
  }
  heed_movement_of_swapped();
}

void SensorHealth::fail_crossed(std::size_t one, std::size_t other) {
  fail_pair(one, other);
  begin_reading_for_each_other(one, other);
  in_use_[one] = in_use_[other] = false;
}

bool SensorHealth::others_kept_course(std::size_t one, std::size_t other) const {
  const double least_K = std::min(channels_[one].off_course_before_K(), channels_[other].off_course_before_K());
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (i != one && i != other && channels_[i].off_course_before_K() > limits_.swap_fit * least_K) return false;
  }
  return true;
}

void SensorHealth::find_replugged() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    for (std::size_t j = i + 1; j < channels_.size(); ++j) {
      if (channels_[i].is_swapped() || channels_[j].is_swapped()) continue;
      if (!channels_[i].swapped_over_gap_with(channels_[j]) || !others_kept_course(i, j)) continue;
      const bool used = channels_[i].was_used() || channels_[j].was_used();
      fail_crossed(i, j);
      if (!used) continue;
      untold_ = {static_cast<int>(i), static_cast<int>(j)};
      untold_.over_gap = true;
    }
  }
}

HealthVerdict SensorHealth::note_update(const std::vector<HealthUpdate>& updates, bool estimate_in_doubt) {
  const HealthVerdict ended =
      end_reading_where([&](std::size_t i) { return updates[i].evidence > limits_.drift_limit; });
  if (ended.failed >= 0) return ended;
  for (std::size_t i = 0; i < channels_.size(); ++i) in_use_[i] = channels_[i].in_use();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    considered_[i] = updates[i];
    considered_[i].taken = updates[i].taken && in_use_[i];
    considered_[i].moves_like = in_use_[i] ? swaps_.partner_of(i, in_use_, limits_) : -1;
  }
  const Blame blame = isolation_.judge(considered_, estimate_in_doubt, time_s_, limits_);
  if (untold_.failed >= 0) {
    note_restart();
    return std::exchange(untold_, {});
  }
  if (blame.channel < 0) return {};
  const auto blamed = static_cast<std::size_t>(blame.channel);
  if (blame.first) return {-1, -1, true, blame.channel};
  if (blame.offset) return {-1, -1, false, -1, blame.channel};
  if (blame.partner >= 0) {
    fail_pair(blamed, static_cast<std::size_t>(blame.partner));
    note_restart();
  } else {
    channels_[blamed].fail_by_evidence(blame.fault, updates[blamed].misfit_K, updates[blamed].deviation_K,
                                       blame.model_in_doubt);
  }
  return {blame.channel, blame.partner};
}

HealthVerdict SensorHealth::note_contradiction() {
  const HealthVerdict ended = end_reading_where([](std::size_t) { return true; });
  if (ended.failed >= 0) return ended;
  for (std::size_t i = 0; i < channels_.size(); ++i) in_use_[i] = channels_[i].in_use();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const int partner = in_use_[i] ? swaps_.partner_of(i, in_use_, limits_) : -1;
    if (partner < 0 || swaps_.partner_of(static_cast<std::size_t>(partner), in_use_, limits_) != static_cast<int>(i))
      continue;
    fail_pair(i, static_cast<std::size_t>(partner));
    note_restart();
    return {static_cast<int>(i), partner};
  }
  return {};
}

HealthVerdict SensorHealth::note_suspect(int channel, double misfit_K, double deviation_K) {
  const Blame blame = isolation_.judge_suspect(channel, misfit_K, deviation_K, time_s_, limits_);
  if (blame.channel < 0) return {};
  if (blame.offset) return {-1, -1, false, -1, channel};
  channels_[static_cast<std::size_t>(channel)].fail_by_evidence(blame.fault, misfit_K, deviation_K, false);
  return {channel, -1};
}

void SensorHealth::note_restart() {
  isolation_.note_restart(time_s_);
  for (Channel& channel : channels_) channel.note_restart(time_s_);
}

void SensorHealth::acknowledge() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (record(i).partner >= 0) swaps_.forget(i);
    channels_[i].acknowledge();
  }
  isolation_.acknowledge();
}

}  // namespace spindle_twin::correction
