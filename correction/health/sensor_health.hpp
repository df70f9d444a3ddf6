#pragma once

#include <vector>

#include "correction/health/channel.hpp"
#include "correction/health/isolation.hpp"
#include "correction/health/limits.hpp"
#include "correction/health/record.hpp"
#include "correction/health/swap_detector.hpp"

namespace spindle_twin::correction {

/// What came of an update: the channel that failed by it, -1: none, and the one it is swapped with, -1: none.
struct HealthVerdict {
  int failed = -1;
  int partner = -1;
  bool loosen = false;    ///< the readings contradict the estimate, which is to be loosened (EstimatorCorrection)
  int suspect = -1;       ///< then: the channel that they would have blamed otherwise
  int opened = -1;        ///< the channel whose offset may have been wrong by return_offset_deviation_K all the time
  bool over_gap = false;  ///< of a pair: it was swapped over a gap in its readings, and right before
};

/// Judges every channel each cycle, so that one that fails leaves before it has moved the estimate, and comes back
/// without a step. Runs, in the order of the README: each channel's own detectors (channel.hpp), what most do at once
/// (the model, not the channels), swaps (swap_detector.hpp), and after each update of the estimator the
/// evidence of all (isolation.hpp). Drift, swap and the third failure of a channel wait for acknowledge().
class SensorHealth {
 public:
  /// One entry per channel. Allocates; nothing else here does.
  SensorHealth(const std::vector<HealthChannel>& channels, const HealthLimits& limits);

  /// One sample per channel at time_s, h_s >= 0 after the one before (0 at the first). May run in the cycle.
  void step(const std::vector<HealthSample>& samples, double time_s, double h_s);

  /// The readings have contradicted the estimate for a minute. The reason are two that are read for each other's
  /// places, where there are such, and they are not any more; else two channels each of which has moved like the
  /// other's place since the start, and they fail as swapped. May run in the cycle.
  HealthVerdict note_contradiction();

  /// As Isolation::judge_suspect(): the channel fails by drift, its offset is to be opened, or neither. May run in the
  /// cycle.
  HealthVerdict note_suspect(int channel, double misfit_K, double deviation_K);

  /// After each update of the estimator, one entry per channel, at the time of the last step. Two that were found to
  /// have been swapped by their movement since the update before are given too: what the estimator learnt from them
  /// is to be forgotten. May run in the cycle.
  HealthVerdict note_update(const std::vector<HealthUpdate>& updates, bool estimate_in_doubt = false);
  /// The estimator began anew, from its priors or otherwise; at the time of the last step. A verdict on a pair, after
  /// which the estimator goes back in time, is such a beginning by itself. May run in the cycle.
  void note_restart();

  /// The channel that shows the place of this one: itself, or the one that it is swapped with and that is read for it
  /// until acknowledge() (HealthLimits::read_swapped); whether its last sample may be used says its record. May run in
  /// the cycle.
  std::size_t reader_of(std::size_t place) const;

  /// Latched channels may return, by way of the probation; counters of failures begin anew, and so does what is known
  /// of the movement of swapped ones. May run in the cycle.
  void acknowledge();

  KeptHealth kept(std::size_t channel) const { return channels_[channel].kept(); }
  /// Before the first step: as Channel::resume(). May run in the cycle.
  void resume(std::size_t channel, const KeptHealth& from, double away_s) { channels_[channel].resume(from, away_s); }

  const HealthRecord& record(std::size_t channel) const { return channels_[channel].record(); }
  std::size_t count() const { return channels_.size(); }
  const HealthLimits& limits() const { return limits_; }
  /// It is the model, not the channels: more of them left their course with this sample than could have failed, half of
  /// them had evidence against them at the last update, or the estimator said so then.
  bool model_in_doubt() const { return left_course_together_ || isolation_.model_in_doubt(); }

 private:
  void follow_what_most_do();
  void find_swapped(const std::vector<HealthSample>& samples, double h_s);
  /// Two that come back from a gap on each other's course, where no third one came back off its own by swap_fit of
  /// what they did: else it is the model. What the estimator took of them since is to be forgotten.
  void find_replugged();
  bool others_kept_course(std::size_t one, std::size_t other) const;
  void fail_pair(std::size_t one, std::size_t other);
  void begin_reading_for_each_other(std::size_t one, std::size_t other);
  /// Two whose courses have been swapped: both are out, and read for each other's places at once.
  void fail_crossed(std::size_t one, std::size_t other);
  /// Two that have failed as swapped, for whatever reason, are read for each other's places once they have moved like
  /// them.
  void heed_movement_of_swapped();
  /// A pair that is read for each other's places, one of which is contradicted there: neither is read any more.
  template <class Contradicted>
  HealthVerdict end_reading_where(Contradicted&& is_contradicted);

  HealthLimits limits_;
  std::vector<Channel> channels_;
  SwapDetector swaps_;
  Isolation isolation_;
  std::vector<HealthUpdate> considered_;  // updates of the channels in use
  std::vector<bool> in_use_;
  HealthVerdict untold_;  // swapped by movement or over a gap, since the last update
  double time_s_ = 0.0;
  bool left_course_together_ = false;
};

}  // namespace spindle_twin::correction
