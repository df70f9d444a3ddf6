#include "correction/health/sensor_health.hpp"

#include <cmath>

namespace spindle_twin::correction {

SensorHealth::SensorHealth(const std::vector<HealthChannel>& channels, const HealthLimits& limits)
    : limits_(limits), exchange_(channels.size()), isolation_(channels.size()), considered_(channels.size()) {
  channels_.reserve(channels.size());
  for (const HealthChannel& channel : channels) channels_.emplace_back(channel, limits);
}

void SensorHealth::step(const std::vector<HealthSample>& samples, double time_s, double h_s) {
  time_s_ = time_s;
  for (std::size_t i = 0; i < channels_.size(); ++i) channels_[i].take(samples[i], time_s, h_s);
  doubt_the_model();
  find_exchanged(samples, h_s);
  for (Channel& channel : channels_) channel.judge();
}

/// When more than half of the channels, and three at least, leave their course with one sample, it is the spindle or
/// the model: all are followed.
void SensorHealth::doubt_the_model() {
  int judged = 0, off_course = 0;
  for (const Channel& channel : channels_) {
    if (!channel.in_use() || !channel.reads()) continue;
    ++judged;
    off_course += channel.off_course() ? 1 : 0;
  }
  model_in_doubt_ = off_course >= 3 && 2 * off_course > judged;
  if (!model_in_doubt_) return;
  for (Channel& channel : channels_) {
    if (channel.in_use() && channel.off_course()) channel.follow_reading();
  }
}

void SensorHealth::find_exchanged(const std::vector<HealthSample>& samples, double h_s) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = channels_[i];
    if (std::isfinite(samples[i].uncorrected_K)) exchange_.note_model(i, samples[i].uncorrected_K, h_s, limits_);
    if (channel.reads() && !channel.off_course()) {
      exchange_.note_reading(i, samples[i].reading_K, channel.elapsed_s(), limits_);
    }
  }
  exchange_.accumulate(h_s, limits_);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    for (std::size_t j = i + 1; j < channels_.size(); ++j) {
      if (!channels_[i].in_use() || !channels_[j].in_use()) continue;
      if (!channels_[i].exchanged_courses_with(channels_[j]) && !exchange_.move_exchanged(i, j, limits_)) continue;
      channels_[i].fail_swapped(static_cast<int>(j));
      channels_[j].fail_swapped(static_cast<int>(i));
    }
  }
}

HealthVerdict SensorHealth::note_update(const std::vector<HealthUpdate>& updates) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    considered_[i] = updates[i];
    considered_[i].taken = updates[i].taken && channels_[i].in_use();
  }
  const Blame blame = isolation_.judge(considered_, time_s_, limits_);
  if (blame.channel < 0) return {};
  Channel& blamed = channels_[static_cast<std::size_t>(blame.channel)];
  if (blame.partner >= 0) {
    blamed.fail_swapped(blame.partner);
    channels_[static_cast<std::size_t>(blame.partner)].fail_swapped(blame.channel);
  } else {
    blamed.fail(blame.fault, blame.fault == HealthFault::drift);
  }
  return {blame.channel, blame.partner};
}

void SensorHealth::acknowledge() {
  for (Channel& channel : channels_) channel.acknowledge();
}

}  // namespace spindle_twin::correction
