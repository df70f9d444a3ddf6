#include "correction/health/stuck_detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace spindle_twin::correction {
namespace {

constexpr std::array shares{1.0, 0.5, 0.5};  // of the limit, that each of the three movements must reach
constexpr double late_share = 0.5;           // of that, as a late sensor shows it
constexpr int least_samples = 4;
constexpr double least_window = 0.25;     // share of the window that a stretch must have
constexpr double hardly = 1e-3;           // a live channel repeats itself for so long once in a thousand runs
constexpr double change_memory = 0.02;    // share of a new reading: fifty readings
constexpr double turns_to_changes = 1.5;  // of white noise two changes in three turn back

/// ln of how much likelier n readings within one step are of a channel that stands than of one whose readings less the
/// model have this sum of squares about their mean.
double evidence(int samples, double spread_K2, const StuckDetector::Sensor& sensor) {
  const double of_one_step = std::log(std::sqrt(2.0 * std::numbers::pi) * sensor.noise_K / (2.0 * sensor.resolution_K));
  const double of_noise = (samples - 1) * std::max(of_one_step, 0.0);
  return sensor.model_settles ? of_noise : 0.5 * spread_K2 / (sensor.noise_K * sensor.noise_K) + of_noise;
}

}  // namespace

void StuckDetector::restart() {
  filled_ = 0;
  seen_ = false;
  repeated_ = 0;
}

void StuckDetector::follow_late(double time_s, const Movements& model_K, double lag_s) {
  if (filled_ == 0) late_K_ = model_K;
  const double passed = filled_ == 0 ? 0.0 : 1.0 - std::exp(-(time_s - late_at_s_) / lag_s);
  for (std::size_t u = 0; u < late_K_.size(); ++u) late_K_[u] += passed * (model_K[u] - late_K_[u]);
  late_at_s_ = time_s;
}

bool StuckDetector::moved(const Bucket& since, const Movements& model_K, double needed_K) const {
  for (std::size_t u = 0; u < model_K.size(); ++u) {
    if (std::abs(model_K[u] - since.model_K[u]) < shares[u] * needed_K) return false;
    if (std::abs(late_K_[u] - since.late_K[u]) < late_share * shares[u] * needed_K) return false;
  }
  return true;
}

void StuckDetector::put(double time_s, double reading_K, const Movements& model_K, const HealthLimits& limits) {
  Bucket* bucket = &ring_[static_cast<std::size_t>(newest_)];
  if (filled_ == 0 || time_s - bucket->begin_s >= limits.stuck_window_s / buckets) {
    newest_ = (newest_ + 1) % buckets;
    filled_ = std::min(filled_ + 1, buckets);
    bucket = &ring_[static_cast<std::size_t>(newest_)];
    *bucket = {time_s, reading_K, reading_K, model_K, late_K_, 0};
  }
  bucket->low_K = std::min(bucket->low_K, reading_K);
  bucket->high_K = std::max(bucket->high_K, reading_K);
  ++bucket->samples;
  const double off_K = reading_K - model_K[0];
  bucket->sum_K += off_K;
  bucket->square_K2 += off_K * off_K;
}

bool StuckDetector::observe(double time_s, double reading_K, const Movements& model_K, const Sensor& sensor,
                            const HealthLimits& limits) {
  const double resolution_K = sensor.resolution_K;
  note_change(reading_K, resolution_K);
  follow_late(time_s, model_K, sensor.lag_s + limits.stuck_lag_s);
  put(time_s, reading_K, model_K, limits);
  const double needed_K = std::max(limits.stuck_K, limits.stuck_resolutions * resolution_K);
  double low_K = reading_K, high_K = reading_K;
  int samples = 0;
  double sum_K = 0.0, square_K2 = 0.0;
  for (int back = 0; back < filled_; ++back) {
    const Bucket& then = ring_[static_cast<std::size_t>((newest_ - back + buckets) % buckets)];
    low_K = std::min(low_K, then.low_K);
    high_K = std::max(high_K, then.high_K);
    samples += then.samples;
    sum_K += then.sum_K;
    square_K2 += then.square_K2;
    if (high_K - low_K > resolution_K * rounding) return false;
    if (samples < least_samples || time_s - then.begin_s < least_window * limits.stuck_window_s) continue;
    const double spread_K2 = square_K2 - sum_K * sum_K / samples;
    if (moved(then, model_K, needed_K) && evidence(samples, spread_K2, sensor) >= limits.stuck_evidence) return true;
  }
  return false;
}

bool StuckDetector::repeats() const {
  const double changing = std::min(change_share_, turns_to_changes * turn_share_);
  return repeated_ >= 3 && std::pow(1.0 - changing, repeated_) < hardly;
}

void StuckDetector::note_change(double reading_K, double resolution_K) {
  if (!seen_) {
    seen_ = true;
    anchor_K_ = reading_K;
    return;
  }
  const bool changed = std::abs(reading_K - anchor_K_) > resolution_K * rounding;
  const double change_K = reading_K - anchor_K_;
  const bool turned = changed && change_K * last_change_K_ < 0.0;
  if (!repeats()) {  // a run that is being withheld teaches nothing about how the channel is when it lives
    change_share_ += change_memory * ((changed ? 1.0 : 0.0) - change_share_);
    turn_share_ += change_memory * ((turned ? 1.0 : 0.0) - turn_share_);
  }
  if (changed) last_change_K_ = change_K;
  repeated_ = changed ? 0 : repeated_ + 1;
  if (changed) anchor_K_ = reading_K;
}

}  // namespace spindle_twin::correction
