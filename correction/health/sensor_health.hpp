#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "correction/health/jump.hpp"
#include "correction/health/limits.hpp"
#include "correction/health/stuck.hpp"
#include "correction/health/swapped.hpp"

namespace spindle_twin::correction {

/// What is constant of a channel.
struct HealthChannel {
  bool configured = false;
  double min_K = 253.15;  ///< range of its own
  double max_K = 423.15;
  double resolution_K = 0.01;  ///< smallest step of the reading
  double noise_K = 0.03;       ///< 1σ of a reading; what is learnt of it stays between 1/3 and 3 times this
  double interval_s = 0.0;     ///< between new readings where these are fewer than the samples
};

/// One reading, and what the model says of its place.
struct HealthSample {
  bool present = false;      ///< a fresh number came in
  double reading_K = 0.0;    ///< as read, without tare
  double predicted_K = 0.0;  ///< of the model for now, before this instant's correction
  double moved_K = 0.0;      ///< of the model since the sample before, by integration alone, without corrections
  /// The same place in a model that is never corrected; NaN where none runs: channels that were swapped from the start
  /// are not found then.
  double uncorrected_K = std::numeric_limits<double>::quiet_NaN();
};

/// What an update of the estimator says of a channel.
struct HealthUpdate {
  bool taken = false;         ///< there was a reading, fused or rejected; false: nothing is said
  double evidence = 0.0;      ///< against the channel, leave_one_out.hpp
  int rejected_in_a_row = 0;  ///< by the estimator
  double reading_K = 0.0;
  double misfit_K = 0.0;  ///< reading − what all others say of it
};

/// What came of an update: the channel that failed by it, -1: none, and the one it is swapped with, -1: none.
struct HealthVerdict {
  int failed = -1;
  int partner = -1;
};

struct HealthRecord {
  HealthState state = HealthState::good;
  HealthFault fault = HealthFault::none;  ///< the last one, kept while not good
  bool usable = false;                    ///< this reading may be used
  bool returned = false;                  ///< became good again with this sample: its offset is not known any more
  double return_offset_K = 0.0;           ///< then: 1σ of its offset
  int partner = -1;                       ///< of a swapped channel
  int failures = 0;                       ///< since the start or the acknowledgement
  int spikes = 0;                         ///< since the start
  double since_s = 0.0;                   ///< time of the last change of state
};

/// Judges every channel each cycle, so that one that fails leaves before it has moved the estimate, and comes back
/// without a step:
///   good → suspect   outlier, repeated reading, one electrical reading: withheld
///   suspect → good   the next reading is on course (a spike, counted)
///   → failed         electrical 2 readings in a row; jump 3 outliers in a row; spikes; stuck; drift; swapped;
///                    implausible
///   failed → returning → good   no sign of a fault for return_after_s, after implausible readings: back on the old
///                    course; drift, swapped and the third failure wait for acknowledge()
/// A jump, implausible readings and drift are laid to a channel only while most others are on course: when more than
/// half of them (and three at least) leave theirs at once it is the spindle or the model, and all are followed.
/// No allocation after construction; may run in the cycle.
class SensorHealth {
 public:
  SensorHealth(std::vector<HealthChannel> channels, const HealthLimits& limits);

  /// One sample per channel, h_s after the one before (0 at the first).
  void step(const std::vector<HealthSample>& samples, double time_s, double h_s);

  /// After each update of the estimator, one entry per channel. At least two others must be in use: of two that
  /// disagree nobody knows which is right.
  HealthVerdict note_update(const std::vector<HealthUpdate>& updates);

  /// Latched channels may return, by way of the probation; counters of failures begin anew.
  void acknowledge();

  const std::vector<HealthRecord>& records() const { return records_; }
  const HealthLimits& limits() const { return limits_; }
  /// More channels left their course at once than could have failed: it is the model.
  bool model_in_doubt() const { return model_in_doubt_; }

 private:
  struct Channel {
    Course course;
    Standstill standstill;
    HighPass reading_movement, model_movement;
    double model_K = 0.0;  // u
    double still_K = 0.0;  // u without what corrections keep taking back
    double last_e_K = 0.0;
    double e_rate_K_per_s = 0.0;
    bool has_last_e = false;
    double old_course_K = 0;  // mean of reading − predicted while good
    bool has_old_course = false;
    double elapsed_s = 0.0;  // since the reading before
    double moved_K = 0.0;    // of the model in that time
    double quiet_s = 0.0;
    double calm_s = 0.0;  // when there was hardly any evidence last
    int electrical = 0;
    int outliers = 0;
    double first_outlier_K = 0.0, first_miss_K = 0.0;
    std::array<double, 16> spike_times_s{};
    int spike_at = 0;
    bool latched = false;
    bool outlying = false;
    double e_K = 0.0, y_K = 0.0, m_K = 0.0;
  };

  HealthFault electrical(std::size_t i, double reading_K) const;
  bool judge_electrical(std::size_t i, const HealthSample& sample, double h_s);
  void find_outliers(const std::vector<HealthSample>& samples);
  void find_swapped(const std::vector<HealthSample>& samples, double h_s);
  bool moves_without(std::size_t i, const HealthSample& sample);
  double left_over_K2(std::size_t i, std::size_t j) const;
  bool exchanged_courses(std::size_t i, std::size_t j) const;
  int exchanged_with(std::size_t w, const std::vector<HealthUpdate>& updates) const;
  void settle(std::size_t i, const HealthSample& sample, double h_s);
  void note_spike(std::size_t i);
  void fail(std::size_t i, HealthFault fault, bool latch);
  void fail_swapped(std::size_t i, std::size_t j);
  void change(std::size_t i, HealthState state);
  void follow_return(std::size_t i, const HealthSample& sample, double h_s);
  bool in_use(std::size_t i) const;
  bool present(std::size_t i, const HealthSample& sample) const;

  std::vector<HealthChannel> channels_;
  HealthLimits limits_;
  std::vector<Channel> states_;
  std::vector<HealthRecord> records_;
  Eigen::MatrixXd product_K2_;         // ⟨y_i m_j⟩
  Eigen::VectorXd reading_square_K2_;  // ⟨y_i²⟩
  Eigen::VectorXd model_square_K2_;    // ⟨m_j²⟩
  double time_s_ = 0.0;
  double drift_wait_s_ = -1e18;  // no failure by drift before
  bool model_in_doubt_ = false;
};

}  // namespace spindle_twin::correction
