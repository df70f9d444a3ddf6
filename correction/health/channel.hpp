#pragma once

#include <limits>

#include "correction/health/channel_states.hpp"
#include "correction/health/course_over_gap.hpp"
#include "correction/health/course_tracker.hpp"
#include "correction/health/electrical_detector.hpp"
#include "correction/health/jump_detector.hpp"
#include "correction/health/limits.hpp"
#include "correction/health/misfit_review.hpp"
#include "correction/health/model_movement.hpp"
#include "correction/health/record.hpp"
#include "correction/health/spike_counter.hpp"
#include "correction/health/stuck_detector.hpp"
#include "correction/health/usual_offset.hpp"

namespace spindle_twin::correction {

/// What is constant of a channel.
struct HealthChannel {
  bool configured = false;
  double min_K = std::numeric_limits<double>::lowest();  ///< range of its own
  double max_K = std::numeric_limits<double>::max();
  double resolution_K = 0.01;  ///< smallest step of the reading
  double noise_K = 0.03;       ///< 1σ of a reading; what is learnt of it stays between 1/3 and 3 times this
  double interval_s = 0.0;     ///< between new readings where these are fewer than the samples
  double lag_s = 0.0;          ///< with which it is said to follow its place
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
  double offset_K = 0.0;  ///< what is known of the reading's: tare, and what the estimator has learnt
};

/// One channel: its detectors, its state (channel_states.hpp) and its record. A sample is judged in two steps, because
/// what most channels do at once is not theirs: take(), then judge(). All functions but the constructor may run in the
/// cycle: no allocation.
class Channel {
 public:
  Channel(const HealthChannel& plan, const HealthLimits& limits) : plan_(plan), limits_(limits) {}

  /// Takes the sample at time_s, h_s >= 0 after the one before (0 at the first): looks at the wire, carries the course
  /// on, and says by off_course() whether the reading is on it.
  void take(const HealthSample& sample, double time_s, double h_s);
  /// The rest: jump, spikes, stuck; of a channel that is out, whether it may return.
  void judge();

  /// The course goes on from this reading, whatever it is: the model is in doubt, or has no say.
  void follow_reading();
  /// The estimate began anew at time_s: for settle_s the model may move where the place does not.
  void note_restart(double time_s) { restart_s_ = time_s; }
  /// Fails by what others found out; latched: it returns only after acknowledge().
  void fail(HealthFault fault, bool latched);
  /// Fails because its readings do not fit those of all others, by misfit_K with 1σ deviation_K > 0. Drift latches, but
  /// only after its review (misfit_review.hpp), and never where the model was in doubt.
  void fail_by_evidence(HealthFault fault, double misfit_K, double deviation_K, bool model_in_doubt);
  /// Fails because it shows the temperature of `partner`, the other one's index. Latched.
  void fail_swapped(int partner);
  /// It is out for that.
  bool is_swapped() const { return latched_ && is_out() && record_.fault == HealthFault::swapped; }
  /// It is sure that it shows its partner's place: its readings may be used for that until acknowledge(), where that is
  /// wanted (HealthLimits::read_swapped) and has not been ended.
  void begin_reading_for_partner() { reads_for_partner_ = limits_.read_swapped && !refused_; }
  bool reads_for_partner() const { return reads_for_partner_ && is_swapped(); }
  /// It does not show its partner's place either: its readings are not used for that any more.
  void end_reading_for_partner() {
    reads_for_partner_ = false;
    refused_ = true;
  }
  KeptHealth kept() const;
  /// Before the first sample: is as out as it was, away_s ago. Whatever it is out for, it returns by the way of the
  /// probation.
  void resume(const KeptHealth& from, double away_s);
  /// A latched channel may return by way of the probation; failures are counted anew.
  void acknowledge();

  /// good or suspect, and configured.
  bool in_use() const { return plan_.configured && !is_out(); }
  /// The sample brought a number, and the wire is right.
  bool reads() const { return present_ && electrical_.is_right(); }
  /// It is an outlier of the channel's course.
  bool off_course() const { return off_course_; }
  /// It is the first after a gap, in which no reading came, or none of a wire that is right.
  bool was_away() const { return was_away_; }
  /// Each of the two left its own course for the other's, with this sample the limits.outliers'th time for one of them.
  bool swapped_courses_with(const Channel& other) const;
  /// Each of the two, one of which has just come back, came back from a gap on the course that the other had before:
  /// both are off their own by more than twice what makes a jump, so that swap_fit of it is six σ of a reading, and
  /// from the other's by swap_fit of that at most.
  bool swapped_over_gap_with(const Channel& other) const;
  /// By how much it reads off the course that it had before a gap; 0 where that is not known (any more).
  double off_course_before_K() const;
  /// It is in use, and this reading is not the first since the start or its last gap: earlier ones have been used.
  bool was_used() const { return in_use() && !gap_.is_first(); }
  /// Since the reading before, this one's time included; valid between take() and judge().
  double elapsed_s() const { return elapsed_s_; }
  const HealthRecord& record() const { return record_; }

 private:
  bool is_out() const { return record_.state == HealthState::failed || record_.state == HealthState::returning; }
  void look_at_wire();
  void judge_in_use(double elapsed_s);
  void judge_outlier();
  void judge_return(double elapsed_s);
  void note_spike();
  /// The course begins anew with the last reading.
  void restart_course(double rate_K_per_s);
  bool is_stuck();
  bool model_settles() const { return time_s_ - restart_s_ < limits_.settle_s; }
  /// The reading belongs to the course, elapsed_s after the one before.
  void accept_reading(double elapsed_s);
  /// By how much the reading is off the last one of its course, as read. What is no more than a course may miss is no
  /// step, however far the model has moved meanwhile.
  double stepped_K() const { return std::abs(sample_.reading_K - on_course_K_); }
  /// Of a channel that failed as stuck: it shows nothing but its old value until it has moved by more than a step of
  /// its resolution, and again where it repeats itself.
  bool stands_still();
  /// Whether the reading of a channel that is out shows that its fault is still there.
  bool shows_fault(double elapsed_s);
  bool fits_course_of(const Channel& other) const;
  /// By how much it reads more than the course of `other` before its gap says.
  double off_course_before_of_K(const Channel& other) const;
  /// Off its own course of before the gap, and on that of `other`.
  bool came_back_as(const Channel& other) const;
  /// The course of before the daemon's gap, from what it read more than the model then.
  void resume_course();
  /// Takes the event through the table.
  void meet(ChannelEvent event, HealthFault cause = HealthFault::none);

  HealthChannel plan_;
  HealthLimits limits_;
  HealthRecord record_;
  ElectricalDetector electrical_;
  CourseTracker course_;
  JumpDetector jump_;
  SpikeCounter spikes_;
  StuckDetector stuck_;
  ModelMovement model_;
  UsualOffset usual_;
  MisfitReview review_;
  CourseOverGap gap_;
  KeptHealth resumed_;  ///< what resume() was given, until the first sample

  HealthSample sample_;  ///< the last one taken
  double time_s_ = 0.0;
  double restart_s_ = 0.0;     ///< of the estimate
  bool present_ = false;       ///< it brought a number
  bool off_course_ = false;    ///< which is an outlier
  double on_course_K_ = 0.0;   ///< last reading of the course
  double jumped_K_ = 0.0;      ///< size of the last jump
  bool was_away_ = false;      ///< which is the first after a gap, with a wire that is right
  double unread_s_ = 0.0;      ///< since the last such reading
  double detrended_K_ = 0.0;   ///< e = r − u, of the last reading
  double elapsed_s_ = 0.0;     ///< since the reading before
  double moved_K_ = 0.0;       ///< of the model in that time
  double without_sign_s_ = 0;  ///< of a fault
  double row_began_s_ = 0.0;   ///< of outliers
  double stood_at_K_ = std::numeric_limits<double>::quiet_NaN();  ///< first reading behind the last verdict
  bool has_moved_ = false;                                        ///< from there
  bool latched_ = false;
  bool reads_for_partner_ = false, refused_ = false;
};

}  // namespace spindle_twin::correction
