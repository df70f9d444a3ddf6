#pragma once

#include <vector>

#include "correction/health/channel.hpp"
#include "correction/health/exchange_detector.hpp"
#include "correction/health/isolation.hpp"
#include "correction/health/limits.hpp"
#include "correction/health/record.hpp"

namespace spindle_twin::correction {

/// What came of an update: the channel that failed by it, -1: none, and the one it is swapped with, -1: none.
struct HealthVerdict {
  int failed = -1;
  int partner = -1;
};

/// Judges every channel each cycle, so that one that fails leaves before it has moved the estimate, and comes back
/// without a step. Runs, in the order of the README: each channel's own detectors (channel.hpp), what most do at once
/// (the model, not the channels), exchanges (exchange_detector.hpp), and after each update of the estimator the
/// evidence of all (isolation.hpp). Drift, exchange and the third failure of a channel wait for acknowledge().
class SensorHealth {
 public:
  /// One entry per channel. Allocates; nothing else here does.
  SensorHealth(const std::vector<HealthChannel>& channels, const HealthLimits& limits);

  /// One sample per channel at time_s, h_s >= 0 after the one before (0 at the first). May run in the cycle.
  void step(const std::vector<HealthSample>& samples, double time_s, double h_s);

  /// After each update of the estimator, one entry per channel, at the time of the last step. May run in the cycle.
  HealthVerdict note_update(const std::vector<HealthUpdate>& updates);

  /// Latched channels may return, by way of the probation; counters of failures begin anew. May run in the cycle.
  void acknowledge();

  const HealthRecord& record(std::size_t channel) const { return channels_[channel].record(); }
  std::size_t count() const { return channels_.size(); }
  const HealthLimits& limits() const { return limits_; }
  /// More channels left their course at once than could have failed: it is the model.
  bool model_in_doubt() const { return model_in_doubt_; }

 private:
  void doubt_the_model();
  void find_exchanged(const std::vector<HealthSample>& samples, double h_s);

  HealthLimits limits_;
  std::vector<Channel> channels_;
  ExchangeDetector exchange_;
  Isolation isolation_;
  std::vector<HealthUpdate> considered_;  // updates of the channels in use
  double time_s_ = 0.0;
  bool model_in_doubt_ = false;
};

}  // namespace spindle_twin::correction
