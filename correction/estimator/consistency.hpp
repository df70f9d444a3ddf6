#pragma once

#include <Eigen/Core>

namespace spindle_twin::correction {

/// When readings contradict the estimate, and how far the network is wrong at a sensor.
struct ConsistencyLimits {
  double floor_K = 0.03;         ///< least of the estimated floor
  double floor_largest_K = 1.0;  ///< and its largest
  double floor_memory_s = 1800.0;
  double nis = 1.5;  ///< squared innovation over its variance, mean over nis_memory_s: more is too much
  double nis_memory_s = 60.0;
  double patience_s = 60.0;  ///< above that for so long: the estimate contradicts its readings
  double calm_nis = 0.5;     ///< back below this, for the patience as well: it fits again
  double rejected_memory_s = 300.0;
  double rejected_share = 0.5;  ///< of the updates in rejected_memory_s: more is a contradiction too
};

/// Statistics of the innovations ν of each sensor, of which V = h P hᵀ + r is the variance that the filter expects:
///   NIS_s     mean of ν²/V over a minute, of readings that the gate rejected too (Bar-Shalom: normalised innovation
///             squared). The errors of a minute count as one in r, so a healthy sensor stays far below 1.
///   floor_s²  mean of ν² − (V − floor²) over half an hour, between the limits: what the network, its structure or the
///             sensor's place is wrong by, from the innovations themselves (Mehra, IEEE Trans. AC 17, 1972); while the
///             estimate is in doubt they say more of it than of the network, and the floor is at its least
///   contradiction: some NIS_s above its limit, or more than half of all readings rejected, for a whole minute
/// From a contradiction until all have been calm for as long the estimate is in doubt. All may run in the cycle but the
/// constructor.
class Consistency {
 public:
  explicit Consistency(const ConsistencyLimits& limits = {}, Eigen::Index sensors = 0);

  void restart();
  /// A sensor's reading in this update. explained_K2: V without the floor's share. Times since its reading before.
  void note(Eigen::Index sensor, double innovation_K, double variance_K2, double explained_K2, bool rejected,
            double since_s);
  /// After all sensors of an update. True: the estimate contradicts its readings, and has to be loosened now.
  bool conclude(double elapsed_s);

  /// The same was found elsewhere: in doubt from now on.
  void contradict();

  bool in_doubt() const { return in_doubt_; }
  /// Mean of ν² over a minute.
  double square_K2(Eigen::Index sensor) const { return square_K2_[sensor]; }
  double nis(Eigen::Index sensor) const { return nis_[sensor]; }
  double largest_nis() const { return nis_.size() > 0 ? nis_.maxCoeff() : 0.0; }
  /// Mean over all sensors and an hour.
  double nis_of_hour() const { return nis_of_hour_; }
  double rejected_share() const { return rejected_share_; }
  double floor_K(Eigen::Index sensor) const;
  double least_floor_K() const { return limits_.floor_K; }
  /// What a sensor showed longer ago says nothing of its floor.
  double floor_memory_s() const { return limits_.floor_memory_s; }
  void set_floor(Eigen::Index sensor, double floor_K) { floor_K2_[sensor] = floor_K * floor_K; }
  /// Largest |ν| of the update that was concluded last, of all its readings.
  double largest_innovation_K() const { return largest_K_; }
  long contradictions() const { return contradictions_; }

 private:
  ConsistencyLimits limits_;
  Eigen::VectorXd nis_, floor_K2_, square_K2_;
  double nis_of_hour_ = 0.0, rejected_share_ = 0.0;
  double above_s_ = 0.0, calm_s_ = 0.0;
  double largest_K_ = 0.0, noted_K_ = 0.0, noted_nis_ = 0.0;
  int noted_ = 0, rejected_ = 0;
  bool in_doubt_ = false;
  long contradictions_ = 0;
};

}  // namespace spindle_twin::correction
