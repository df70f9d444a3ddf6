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
  double misfit_K = 0.0;             ///< reading − what all others say of it
  double deviation_K = 1.0;          ///< 1σ of that
  bool is_unlikely_without = false;  ///< is_unlikely_machine() of the filter without the channel
  int moves_like = -1;  ///< channel whose place it moves like (SwapDetector::partner_of); set by SensorHealth
};

/// Whom the evidence blames, and for what.
struct Blame {
  int channel = -1;  ///< -1: nobody
  int partner = -1;  ///< the one it is swapped with, -1: none
  HealthFault fault = HealthFault::none;
  bool model_in_doubt = false;  ///< while the model was in doubt: the channel may be healthy after all
  bool first = false;           ///< the first in second_opinion_s: it is laid to the model
  bool offset = false;          ///< the channel's offset may be the reason: it is to be opened
};

/// Which channel the evidence of all blames: the one with most, above drift_limit, that leads the next by drift_lead;
/// then none for drift_wait_s. It is named by its rate: what rose within drift_least_s, or what the estimator rejected
/// twice in a row by then, came too fast for a drift and is implausible.
///   It is swapped with the channel whose place it moves like since the start, if there is one. Else with one whose
/// evidence is above swap_evidence too, where the first's came within swap_s and each reading fits the other's
/// place (left_when_swapped). For either there is no lead to ask for.
///   A step of the spindle (flow, film, inlet) near one sensor looks like a fault of that sensor until the estimate has
/// followed it. So the first verdict by evidence, a swap aside, is laid to the model, which is to be loosened;
/// only a second one within second_opinion_s blames the channel. One that was never tared is off from the start as far
/// as a slow drift comes in time: where the misfit is what its offset may be, three return_offset_deviation_K, the
/// first verdict of drift on a channel opens its offset, and only the next fails it.
///   At least three must have been judged, for a swap four: of two that disagree nobody knows which is right.
///   A wrong model contradicts many sensors. While the estimator says so, or half of the channels (two at least) have
/// evidence above doubt_share of drift_limit at the same time, only what explains the misfit alone is blamed: a
/// channel, or a pair, whose evidence is more than the sum of all others', or what moves like another's place.
///   Where the machine is an unlikely one in the filter without the channel too (estimator/reduced_chi_square.hpp), the
/// model is in doubt, and the channel is blamed for a swap only.
///   In the first settle_s after the start or a restart of the estimator all evidence is against its priors: only what
/// moves like another's place is blamed, and what was gathered by their end counts no more.
class Isolation {
 public:
  /// Allocates; nothing else here does.
  explicit Isolation(std::size_t channels);

  /// The estimator began anew at time_s: its priors are to settle first. May run in the cycle.
  void note_restart(double time_s);

  /// One entry per channel; `taken` only for those that are in use. After each update of the estimator, at time_s, not
  /// earlier than before. May run in the cycle.
  Blame judge(const std::vector<HealthUpdate>& updates, bool estimate_in_doubt, double time_s,
              const HealthLimits& limits);

  /// What came next speaks against the channel of a first verdict, and not against the model (second_opinion.hpp); a
  /// filter that has never seen it says that it is off by so much: its offset is to be opened where that may be the
  /// reason, else it drifts where that is more than opinion_deviations; else nobody is blamed. May run in the cycle.
  Blame judge_suspect(int channel, double misfit_K, double deviation_K, double time_s, const HealthLimits& limits);

  /// Each channel's offset may be the reason of a verdict once more. May run in the cycle.
  void acknowledge();

  /// At the last update: the estimator said so, or the evidence does. May run in the cycle.
  bool model_in_doubt() const { return model_in_doubt_; }

  /// What is left of the misfits of two when each is held against what the others say of the place of the other, t =
  /// reading − misfit:
  ///   (|y_i − t_j| + |y_j − t_i|) / (|misfit_i| + |misfit_j|)
  /// Swapped ones contradict all others by as much, one up and one down; one that drifts by itself bends what is said
  /// of a neighbour, but less: infinite where the misfits differ by more than swap_alike. May run in the cycle.
  static double left_when_swapped(const HealthUpdate& one, const HealthUpdate& other, const HealthLimits& limits);

 private:
  /// What is remembered of a channel.
  struct Memory {
    double calm_s = 0.0;   ///< time at which there was hardly any evidence last, that of the start included
    double settled = 0.0;  ///< evidence gathered while the estimator settled, as it has faded since
    double counted = 0.0;  ///< evidence without that
    bool opened = false;   ///< its offset has been opened: the next verdict fails it
  };
  void count_evidence(const std::vector<HealthUpdate>& updates, double time_s, const HealthLimits& limits);
  /// Whether the channel's offset may be the reason of its misfit, and has not been opened yet.
  bool may_be_offset(int channel, double misfit_K, const HealthLimits& limits) const;
  /// Drift, or its offset, once until acknowledge().
  Blame blame_drift(int channel, double misfit_K, const HealthLimits& limits);
  /// Evidence of the channel and its partner (-1: none) against the sum of all others'.
  bool explains_alone(const std::vector<HealthUpdate>& updates, int channel, int partner) const;
  int partner_of(std::size_t channel, const std::vector<HealthUpdate>& updates, double time_s,
                 const HealthLimits& limits) const;

  std::vector<Memory> memories_;
  double restart_s_ = 0.0;
  double last_s_ = 0.0;  // time of the last update
  double wait_until_s_;
  double first_until_s_;  // a verdict until then is the second one
  bool model_in_doubt_ = false;
};

}  // namespace spindle_twin::correction
