#pragma once

#include <array>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// No change beyond one step q of the reading's resolution while the model moves: over some stretch of the last
/// stuck_window_s, at least a quarter of it and four samples long,
///   max r − min r <= q    and    |u_now − u_then| >= max(stuck_K, stuck_resolutions · q)
/// with each of three u: what the model has moved by integration; that, less the rate at which corrections have taken
/// it back on the mean of the last ten minutes; and the model that is never corrected; half the limit does for the last
/// two. And half of that for what a sensor shows that follows u with its own lag and stuck_lag_s:
///   dy/dt = (u − y) / lag
/// And noise of deviation s would hardly hide the movement: with e = r − u over the n readings of the stretch,
///   Σ (e − mean e)² / 2 s² + (n − 1) max(ln(√(2π) s / 2 q), 0) >= stuck_evidence
/// which is how much likelier these readings are of a channel that stands than of one that follows. While the model
/// settles, none is held against it: it may relax from a start that was none of the spindle's, and what a live sensor
/// shows of a place that stands then is its noise, the second term alone.
///   A late sensor stands still for a while where its place has begun to move, and may by chance have done so before. A
/// steady spindle raises nothing, whatever the corrected model does, because the uncorrected one stands still. One step
/// of q is allowed because a held analogue value flickers between two counts.
///   Besides, repeats() looks for runs of equal readings that a live channel with its usual share p of changes would
/// hardly have ((1 − p)^n < 1 in 1000): these are withheld, which costs a healthy channel nothing. Only changes of
/// noise, which turn back, count for p: a smooth rise that comes to its end is not stuck.
class StuckDetector {
 public:
  /// Steps of resolution are compared as binary numbers.
  static constexpr double rounding = 1.0 + 1e-6;

  /// What a sensor makes of its place's temperature.
  struct Sensor {
    double resolution_K;         ///< above 0
    double noise_K;              ///< 1σ of a reading, above 0
    double lag_s = 0.0;          ///< that it is said to have
    bool model_settles = false;  ///< what the model moves may be its own: it began, or began anew, not long ago
  };

  /// The place's temperature in the model: integrated, the same without steady corrections, never corrected. [K], from
  /// any zero.
  using Movements = std::array<double, 3>;

  /// After a gap in the readings: nothing of what was before counts. May run in the cycle.
  void restart();

  /// One reading at time_s. True if the channel is stuck. May run in the cycle: no allocation, at
  /// most twelve steps.
  bool observe(double time_s, double reading_K, const Movements& model_K, const Sensor& sensor,
               const HealthLimits& limits);

  /// The last readings are equal for longer than a live channel would. May run in the cycle.
  bool repeats() const;

 private:
  /// Extremes of the readings in a twelfth of the window, and u and y at its beginning.
  struct Bucket {
    double begin_s = 0.0, low_K = 0.0, high_K = 0.0;
    Movements model_K{}, late_K{};
    int samples = 0;
    double sum_K = 0.0, square_K2 = 0.0;  ///< of e
  };
  void note_change(double reading_K, double resolution_K);
  void put(double time_s, double reading_K, const Movements& model_K, const HealthLimits& limits);
  void follow_late(double time_s, const Movements& model_K, double lag_s);
  bool moved(const Bucket& since, const Movements& model_K, double needed_K) const;

  static constexpr int buckets = 12;
  std::array<Bucket, buckets> ring_{};
  int newest_ = 0;
  int filled_ = 0;
  Movements late_K_{};
  double late_at_s_ = 0.0;
  double change_share_ = 0.0;  ///< of the readings that differ from the one before
  double turn_share_ = 0.0;    ///< of those that change against the direction of the last change
  double last_change_K_ = 0.0;
  double anchor_K_ = 0.0;  ///< the value that repeats
  int repeated_ = 0;
  bool seen_ = false;
};

}  // namespace spindle_twin::correction
