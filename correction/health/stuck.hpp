#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// No change beyond one step q of the reading's resolution while the model moves: over some stretch of the last
/// stuck_window_s, at least a quarter of it and four samples long,
///   max r − min r <= q    and    |u_now − u_then| >= max(stuck_K, stuck_resolutions · q)
/// with each of three u: what the model has moved by integration; that, less the rate at which corrections have taken
/// it back on the mean of the last ten minutes; and the model that is never corrected; half the limit does for the last
/// two. A steady spindle raises nothing, whatever the corrected model does, because the last one stands. One step of q
/// is allowed because a held analogue value flickers between two counts. Kept in buckets of a twelfth of the window.
/// Besides, `repeats` looks for runs that a live reading with its usual share p of changes would hardly have
/// ((1 − p)^n < 1 in 1000): these are withheld, which costs a healthy channel nothing. Only changes of noise, which
/// turn back, count for p: a smooth rise that comes to its end is not stuck. Runs in the cycle.
struct Standstill {
  static constexpr int buckets = 12;
  static constexpr std::array shares{1.0, 0.5, 0.5};  ///< of the limit, that each u must reach
  static constexpr double hardly = 1e-3;
  static constexpr double change_memory = 0.02;
  static constexpr double turns_to_changes = 1.5;  ///< of white noise two changes in three turn back

  using Movements = std::array<double, 3>;
  struct Bucket {
    double begin_s = 0.0, low_K = 0.0, high_K = 0.0;
    Movements model_K{};
    int samples = 0;
  };
  std::array<Bucket, buckets> ring{};
  int newest = 0;
  int filled = 0;
  double change_share = 0.0;
  double turn_share = 0.0;  ///< changes against the one before
  double last_change_K = 0.0;
  double anchor_K = 0.0;
  int repeated = 0;
  bool seen = false;

  void restart() {
    filled = 0;
    seen = false;
    repeated = 0;
  }

  /// model_K: u. True if the channel is stuck.
  bool observe(double time_s, double reading_K, const Movements& model_K, double resolution_K,
               const HealthLimits& limits) {
    note_change(reading_K, resolution_K);
    Bucket* bucket = &ring[static_cast<std::size_t>(newest)];
    if (filled == 0 || time_s - bucket->begin_s >= limits.stuck_window_s / buckets) {
      newest = (newest + 1) % buckets;
      filled = std::min(filled + 1, buckets);
      bucket = &ring[static_cast<std::size_t>(newest)];
      *bucket = {time_s, reading_K, reading_K, model_K, 0};
    }
    bucket->low_K = std::min(bucket->low_K, reading_K);
    bucket->high_K = std::max(bucket->high_K, reading_K);
    ++bucket->samples;

    const double needed_K = std::max(limits.stuck_K, limits.stuck_resolutions * resolution_K);
    double low_K = reading_K, high_K = reading_K;
    int samples = 0;
    for (int back = 0; back < filled; ++back) {
      const Bucket& then = ring[static_cast<std::size_t>((newest - back + buckets) % buckets)];
      low_K = std::min(low_K, then.low_K);
      high_K = std::max(high_K, then.high_K);
      samples += then.samples;
      if (high_K - low_K > resolution_K * (1.0 + 1e-6)) return false;
      if (samples < 4 || time_s - then.begin_s < 0.25 * limits.stuck_window_s) continue;
      bool moves = true;
      for (std::size_t u = 0; u < model_K.size(); ++u) {
        moves = moves && std::abs(model_K[u] - then.model_K[u]) >= shares[u] * needed_K;
      }
      if (moves) return true;
    }
    return false;
  }

  bool repeats() const {
    const double p = std::min({change_share, turns_to_changes * turn_share, 0.99});
    return repeated >= 3 && std::pow(1.0 - p, repeated) < hardly;
  }

 private:
  void note_change(double reading_K, double resolution_K) {
    if (!seen) {
      seen = true;
      anchor_K = reading_K;
      return;
    }
    const bool changed = std::abs(reading_K - anchor_K) > resolution_K * (1.0 + 1e-6);
    // A run that is being withheld teaches nothing about how the channel is when it lives.
    const double change_K = reading_K - anchor_K;
    const bool reversed = changed && change_K * last_change_K < 0.0;
    if (!repeats()) {
      change_share += change_memory * ((changed ? 1.0 : 0.0) - change_share);
      turn_share += change_memory * ((reversed ? 1.0 : 0.0) - turn_share);
    }
    if (changed) last_change_K = change_K;
    repeated = changed ? 0 : repeated + 1;
    if (changed) anchor_K = reading_K;
  }
};

}  // namespace spindle_twin::correction
