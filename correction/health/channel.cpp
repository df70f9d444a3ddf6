#include "correction/health/channel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::correction {
namespace {

// A sensor that jumped is off by its step, and a second one while it was out; what else departs is the model.
constexpr double jump_sizes = 2.0;

}  // namespace

void Channel::meet(ChannelEvent event, HealthFault cause) {
  const auto [next, action] = transition(record_.state, event);
  if (next != record_.state) record_.since_s = time_s_;
  record_.state = next;
  switch (action) {
    case ChannelAction::none:
      break;
    case ChannelAction::use:
      record_.fault = HealthFault::none;
      record_.usable = true;
      break;
    case ChannelAction::withhold:
      record_.fault = cause;
      break;
    case ChannelAction::fail:
      ++record_.failures;
      [[fallthrough]];
    case ChannelAction::fail_again:
      // Another fault in the meantime does not take a verdict of drift back.
      latched_ = latched_ || (record_.fault == HealthFault::drift && review_.will_latch());
      record_.fault = cause;
      record_.usable = false;
      latched_ = latched_ || record_.failures >= limits_.failures;
      review_.dismiss();
      stood_at_K_ = std::numeric_limits<double>::quiet_NaN();
      jump_.end_row();
      course_.restart();
      model_.interrupt();
      [[fallthrough]];
    case ChannelAction::restart_probation:
      without_sign_s_ = 0.0;
      break;
    case ChannelAction::readmit:
      record_.fault = HealthFault::none;
      record_.returned = record_.usable = true;
      record_.partner = -1;
      break;
  }
}

void Channel::fail(HealthFault fault, bool latched) {
  latched_ = latched_ || latched;
  meet(ChannelEvent::fault, fault);
}

void Channel::fail_by_evidence(HealthFault fault, double misfit_K, double deviation_K, bool model_in_doubt) {
  fail(fault, false);
  review_.begin(time_s_, misfit_K, deviation_K, model_in_doubt);
}

void Channel::fail_swapped(int partner) {
  fail(HealthFault::swapped, true);
  record_.partner = partner;
}

KeptHealth Channel::kept() const {
  return {is_out() ? record_.fault : HealthFault::none,
          latched_,
          record_.partner,
          record_.failures,
          reads_for_partner_,
          usual_.mean_K(),
          gap_.age_s(time_s_)};
}

void Channel::resume(const KeptHealth& from, double away_s) {
  resumed_ = from;
  resumed_.used_before_s += away_s;
  record_.failures = from.failures;
  if (from.fault == HealthFault::none) return;
  record_.failures = std::max(0, from.failures - 1);  // the failure itself is counted again
  fail(from.fault, from.latched);
  record_.partner = from.partner;
  if (from.read_for_partner) begin_reading_for_partner();
}

void Channel::acknowledge() {
  latched_ = reads_for_partner_ = refused_ = false;
  review_.dismiss();
  record_.failures = 0;
}

void Channel::resume_course() {
  const double before_K = sample_.predicted_K + resumed_.usual_offset_K - model_.integrated_K();
  if (std::isfinite(before_K)) gap_.resume(before_K, time_s_, resumed_.used_before_s);
  resumed_ = {};
}

void Channel::take(const HealthSample& sample, double time_s, double h_s) {
  sample_ = sample;
  time_s_ = time_s;
  record_.usable = record_.returned = record_.read_for_partner = off_course_ = was_away_ = false;
  model_.add(sample.moved_K, h_s);
  if (std::isfinite(resumed_.usual_offset_K)) resume_course();
  elapsed_s_ += h_s;
  unread_s_ += h_s;
  moved_K_ += sample.moved_K;
  present_ = plan_.configured && sample.present && std::isfinite(sample.reading_K);
  if (!present_) return;
  const double gap_s = std::max(limits_.gap_s, limits_.gap_intervals * plan_.interval_s);
  if (elapsed_s_ > gap_s) {
    course_.restart();
    stuck_.restart();
    model_.interrupt();
  }
  course_.carry_on(moved_K_, elapsed_s_, plan_.resolution_K, limits_);
  look_at_wire();
  if (!electrical_.is_right()) return;
  was_away_ = unread_s_ > gap_s;
  gap_.note_reading(time_s, was_away_, limits_);
  unread_s_ = 0.0;
  detrended_K_ = sample.reading_K - model_.integrated_K();
  off_course_ = course_.is_outlier(detrended_K_) && stepped_K() > course_.least_jump_K(plan_.resolution_K, limits_);
}

void Channel::look_at_wire() {
  const HealthFault fault = ElectricalDetector::judge(sample_.reading_K, plan_.min_K, plan_.max_K, limits_);
  if (fault == HealthFault::none) {
    if (electrical_.note_right() && !is_out()) note_spike();
  } else if (electrical_.note_fault(limits_)) {
    meet(ChannelEvent::fault, fault);
  } else {
    meet(ChannelEvent::doubtful, fault);
  }
}

void Channel::note_spike() {
  ++record_.spikes;
  if (spikes_.note(time_s_, limits_)) meet(ChannelEvent::fault, HealthFault::spikes);
}

void Channel::restart_course(double rate_K_per_s) {
  jump_.end_row();
  course_.begin(detrended_K_, rate_K_per_s, plan_.noise_K);
  on_course_K_ = sample_.reading_K;
}

void Channel::accept_reading(double elapsed_s) {
  course_.accept(detrended_K_, elapsed_s, plan_.noise_K);
  on_course_K_ = sample_.reading_K;
}

void Channel::follow_reading() {
  off_course_ = false;
  restart_course(0.0);
}

bool Channel::fits_course_of(const Channel& other) const {
  const double off_K = detrended_K_ + model_.integrated_K() - other.course_.expected_K() - other.model_.integrated_K();
  return std::abs(off_K) <= other.course_.limit_K();
}

bool Channel::swapped_courses_with(const Channel& other) const {
  return off_course_ && other.off_course_ && fits_course_of(other) && other.fits_course_of(*this) &&
         std::max(jump_.in_a_row(), other.jump_.in_a_row()) + 1 >= limits_.outliers;
}

double Channel::off_course_before_of_K(const Channel& other) const {
  return detrended_K_ + model_.integrated_K() - other.gap_.before_K() - other.model_.integrated_K();
}

double Channel::off_course_before_K() const {
  return reads() && gap_.is_known(time_s_, limits_) ? std::abs(off_course_before_of_K(*this)) : 0.0;
}

bool Channel::came_back_as(const Channel& other) const {
  const double own_K = off_course_before_K();
  return own_K > 2.0 * course_.least_jump_K(plan_.resolution_K, limits_) &&
         std::abs(off_course_before_of_K(other)) <= limits_.swap_fit * own_K;
}

bool Channel::swapped_over_gap_with(const Channel& other) const {
  const bool just_ended = gap_.has_just_ended(limits_) || other.gap_.has_just_ended(limits_);
  return just_ended && came_back_as(other) && other.came_back_as(*this);
}

bool Channel::is_stuck() {
  const double uncorrected_K = std::isfinite(sample_.uncorrected_K) ? sample_.uncorrected_K : model_.integrated_K();
  return stuck_.observe(time_s_, sample_.reading_K, {model_.integrated_K(), model_.steady_K(), uncorrected_K},
                        {plan_.resolution_K, course_.noise_K(plan_.noise_K), plan_.lag_s, model_settles()}, limits_);
}

void Channel::judge() {
  if (!present_) return;
  const double elapsed_s = elapsed_s_;
  elapsed_s_ = moved_K_ = 0.0;
  if (!electrical_.is_right()) return;
  if (is_out()) {
    judge_return(elapsed_s);
  } else {
    judge_in_use(elapsed_s);
  }
}

void Channel::judge_outlier() {
  if (jump_.in_a_row() == 0) row_began_s_ = time_s_;
  switch (jump_.note_outlier(detrended_K_, course_.expected_K(), limits_)) {
    case JumpDetector::Meaning::open:
      meet(ChannelEvent::doubtful, HealthFault::jump);
      break;
    case JumpDetector::Meaning::jump:
      jumped_K_ = stepped_K();
      meet(ChannelEvent::fault, HealthFault::jump);
      break;
    case JumpDetector::Meaning::place_moves:
      restart_course(jump_.since_first_K() / (time_s_ - row_began_s_));
      break;
  }
}

void Channel::judge_in_use(double elapsed_s) {
  if (off_course_) {
    judge_outlier();
    return;
  }
  if (jump_.end_row()) note_spike();
  if (is_out()) return;
  accept_reading(elapsed_s);
  gap_.note_course(course_.expected_K(), time_s_);
  if (is_stuck()) {
    meet(ChannelEvent::fault, HealthFault::stuck);
  } else if (stuck_.repeats()) {
    model_.interrupt();
    meet(ChannelEvent::doubtful, HealthFault::stuck);
  } else {
    model_.learn(detrended_K_, elapsed_s);
    usual_.learn(sample_.reading_K - sample_.predicted_K, elapsed_s);
    meet(ChannelEvent::on_course);
  }
}

bool Channel::stands_still() {
  if (!std::isfinite(stood_at_K_)) {
    stood_at_K_ = sample_.reading_K;
    has_moved_ = false;
  }
  const double moved_K = std::abs(sample_.reading_K - stood_at_K_);
  has_moved_ = has_moved_ || moved_K > plan_.resolution_K * StuckDetector::rounding;
  return !has_moved_ || stuck_.repeats();
}

bool Channel::shows_fault(double elapsed_s) {
  const bool still = is_stuck() || (record_.fault == HealthFault::stuck && stands_still());
  const double departure_K = std::abs(usual_.departure_K(sample_.reading_K - sample_.predicted_K));
  review_.note(sample_.reading_K - sample_.offset_K - sample_.predicted_K, elapsed_s);
  if (off_course_ || still) return true;
  const bool misfit_has_gone = review_.is_active() && review_.has_gone(limits_);
  if (record_.fault == HealthFault::drift && review_.is_active()) return !misfit_has_gone;
  if (record_.fault != HealthFault::implausible) return departure_K > limits_.return_within_K;
  return departure_K > std::min(limits_.jump_K, limits_.return_within_K) && !misfit_has_gone;
}

void Channel::judge_return(double elapsed_s) {
  if (shows_fault(elapsed_s)) {
    if (off_course_) course_.restart();
    meet(ChannelEvent::sign_of_fault);
    if (record_.fault == HealthFault::drift && review_.is_over(time_s_, limits_)) latched_ = true;
  } else {
    without_sign_s_ += elapsed_s;
  }
  accept_reading(elapsed_s);
  record_.read_for_partner = reads_for_partner() && without_sign_s_ > 0.0;
  if (latched_ || without_sign_s_ <= 0.0) return;
  if (without_sign_s_ < limits_.return_after_s) {
    meet(ChannelEvent::calm);
    return;
  }
  // A verdict that was taken back was no failure.
  if (review_.is_active() && record_.fault == HealthFault::drift) --record_.failures;
  const double departure_K = std::abs(usual_.departure_K(sample_.reading_K - sample_.predicted_K));
  const double most_K = record_.fault == HealthFault::jump ? jump_sizes * jumped_K_ : departure_K;
  record_.return_offset_deviation_K = limits_.return_offset_deviation_K + std::min(departure_K, most_K);
  usual_.forget();
  review_.dismiss();
  meet(ChannelEvent::probation_over);
}

}  // namespace spindle_twin::correction
