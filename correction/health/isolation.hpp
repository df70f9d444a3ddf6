#pragma once

#include <vector>

#include "correction/health/limits.hpp"
#include "correction/health/record.hpp"

namespace spindle_twin::correction {

/// What an update of the estimator says of a channel.
struct HealthUpdate {
  bool taken = false;         ///< there was a reading, fused or rejected; false: nothing is said
  double evidence = 0.0;      ///< against the channel, leave_one_out.hpp
  int rejected_in_a_row = 0;  ///< by the estimator
  double reading_K = 0.0;
  double misfit_K = 0.0;  ///< reading − what all others say of it
};

/// Whom the evidence blames, and for what.
struct Blame {
  int channel = -1;  ///< -1: nobody
  int partner = -1;  ///< the one it is exchanged with, -1: none
  HealthFault fault = HealthFault::none;
};

/// Which channel the evidence of all blames: the one with most, above drift_limit, that leads the next by drift_lead;
/// then none for drift_wait_s. What the estimator rejected twice in a row by then came too fast for a drift:
/// implausible.
///   Two are exchanged where the evidence came within exchange_s, the second's is above exchange_evidence too, and each
/// reading fits the other's place (left_when_exchanged); then there is no lead to ask for.
///   At least three must have been judged, for an exchange four: of two that disagree nobody knows which is right.
class Isolation {
 public:
  /// Allocates.
  explicit Isolation(std::size_t channels);

  /// One entry per channel; `taken` only for those that are in use. After each update of the estimator, at time_s, not
  /// earlier than before. May run in the cycle.
  Blame judge(const std::vector<HealthUpdate>& updates, double time_s, const HealthLimits& limits);

  /// What is left of the misfits of two when each is held against what the others say of the place of the other, t =
  /// reading − misfit:
  ///   (|y_i − t_j| + |y_j − t_i|) / (|misfit_i| + |misfit_j|)
  /// Exchanged ones contradict all others by as much, one up and one down; one that drifts by itself bends what is said
  /// of a neighbour, but less: infinite where the misfits differ by more than exchange_alike. May run in the cycle.
  static double left_when_exchanged(const HealthUpdate& one, const HealthUpdate& other, const HealthLimits& limits);

 private:
  int partner_of(std::size_t channel, const std::vector<HealthUpdate>& updates, double time_s,
                 const HealthLimits& limits) const;

  std::vector<double> calm_s_;  // time at which there was hardly any evidence last, per channel
  double wait_until_s_;
};

}  // namespace spindle_twin::correction
