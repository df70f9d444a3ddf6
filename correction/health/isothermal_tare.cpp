#include "correction/health/isothermal_tare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

/// Largest minus smallest of what is noted.
struct Spread {
  double low = 0.0, high = 0.0;
  int count = 0;
  void note(double value) {
    low = count == 0 ? value : std::min(low, value);
    high = count == 0 ? value : std::max(high, value);
    ++count;
  }
  double width() const { return high - low; }
};

}  // namespace

IsothermalTare::IsothermalTare(std::size_t channels, const TareLimits& limits) : limits_(limits) {
  for (Block* block : {&earlier_, &later_, &filling_}) {
    block->sum_K.assign(channels, 0.0);
    block->samples.assign(channels, 0);
  }
}

void IsothermalTare::begin(Block& block) {
  std::fill(block.sum_K.begin(), block.sum_K.end(), 0.0);
  std::fill(block.samples.begin(), block.samples.end(), 0);
}

void IsothermalTare::step(const std::vector<TareSample>& samples, bool heated, double h_s) {
  heated_ = heated;
  if (heated) {
    rest_s_ = filled_s_ = 0.0;
    blocks_ = 0;
    whole_ = offered_ = false;
    judged_ = TareWait::rest;
    begin(filling_);
    return;
  }
  rest_s_ += h_s;
  filled_s_ += h_s;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].valid || !std::isfinite(samples[i].reading_K)) continue;
    filling_.sum_K[i] += samples[i].reading_K;
    ++filling_.samples[i];
  }
  if (filled_s_ < limits_.block_s) return;
  filled_s_ = 0.0;
  std::swap(earlier_, later_);
  std::swap(later_, filling_);
  begin(filling_);
  blocks_ = std::min(blocks_ + 1, 2);
  whole_ = blocks_ == 2;
  judge(samples);
}

void IsothermalTare::judge(const std::vector<TareSample>& samples) {
  judged_ = TareWait::rest;
  judged_channel_ = -1;
  if (whole_ && rest_s_ >= limits_.rest_s) judge_spread(samples);
  offered_ = judged_ == TareWait::nothing;
}

void IsothermalTare::judge_spread(const std::vector<TareSample>& samples) {
  Spread readings, model;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!both(i)) continue;
    const double change_K = mean_K(later_, i) - mean_K(earlier_, i);
    if (std::abs(change_K) > limits_.rate_K_per_h * limits_.block_s / rom::seconds_per_hour) {
      judged_ = TareWait::change;
      judged_channel_ = static_cast<int>(i);
      return;
    }
    readings.note(middle_K(i));
    model.note(samples[i].model_K);
  }
  if (readings.count < 2) {
    judged_ = TareWait::sensors;
  } else if (!(readings.width() <= limits_.spread_K)) {
    judged_ = TareWait::apart;
    judged_channel_ = furthest();
  } else {
    judged_ = model.width() <= limits_.model_spread_K ? TareWait::nothing : TareWait::model;
  }
}

/// The channel furthest from the mean of all.
int IsothermalTare::furthest() const {
  double sum_K = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < earlier_.sum_K.size(); ++i) {
    if (!both(i)) continue;
    sum_K += middle_K(i);
    ++count;
  }
  int channel = -1;
  double most_K = -1.0;
  for (std::size_t i = 0; i < earlier_.sum_K.size(); ++i) {
    const double away_K = both(i) ? std::abs(middle_K(i) - sum_K / count) : -1.0;
    if (away_K <= most_K) continue;
    most_K = away_K;
    channel = static_cast<int>(i);
  }
  return channel;
}

TareOutlook IsothermalTare::outlook() const {
  if (heated_) return {TareWait::heat, -1, std::numeric_limits<double>::quiet_NaN()};
  const double block_left_s = limits_.block_s - filled_s_;
  if (whole_ && judged_ != TareWait::rest) return {judged_, judged_channel_, block_left_s};
  const double blocks_left_s = block_left_s + (blocks_ == 0 ? limits_.block_s : 0.0);
  return {TareWait::rest, -1, std::max({limits_.rest_s - rest_s_, blocks_left_s, 0.0})};
}

bool IsothermalTare::take(double ambient_K, double noise_K, SensorTare& tare) const {
  if (!offered_) return false;
  const std::size_t channels = earlier_.sum_K.size();
  double sum_K = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < channels; ++i) {
    if (!both(i)) continue;
    sum_K += middle_K(i);
    ++count;
  }
  const double common_K = std::isfinite(ambient_K) ? ambient_K : sum_K / count;
  tare.offset_K.resize(channels, 0.0);
  tare.deviation_K.resize(channels, 0.0);
  for (std::size_t i = 0; i < channels; ++i) {
    if (!both(i)) continue;
    tare.offset_K[i] = middle_K(i) - common_K;
    tare.deviation_K[i] = std::sqrt(noise_K * noise_K / (earlier_.samples[i] + later_.samples[i]) +
                                    limits_.common_deviation_K * limits_.common_deviation_K);
  }
  ++tare.count;
  return true;
}

void IsothermalTare::clear(SensorTare& tare) {
  std::fill(tare.offset_K.begin(), tare.offset_K.end(), 0.0);
  std::fill(tare.deviation_K.begin(), tare.deviation_K.end(), 0.0);
  ++tare.count;
}

}  // namespace spindle_twin::correction
