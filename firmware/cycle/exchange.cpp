#include "firmware/cycle/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace spindle_twin::firmware {
namespace {

/// Without which no prediction may be shown.
bool has_failed(const Snapshot& snapshot) {
  constexpr auto failures = static_cast<std::uint16_t>(bits(Fault::integrator_failed) | bits(Fault::prediction_lost) |
                                                       bits(Fault::implausible_prediction));
  if ((snapshot.fault & failures) != 0) return true;
  if (snapshot.state == State::starting) return false;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    if (!std::isfinite(snapshot.predicted_K[k])) return true;
  }
  for (std::size_t d = 0; d < snapshot.deformations; ++d) {
    if (!std::isfinite(snapshot.deformation_raw_m[d])) return true;
  }
  return false;
}

bool is_in_doubt(const Snapshot& snapshot) { return (snapshot.quality & bits(Quality::estimate_in_doubt)) != 0; }

/// What of `one` is amiss that is not amiss of `other` as well.
ExchangeReason trouble_of(const Snapshot& one, const Snapshot& other) {
  if (has_failed(one) && !has_failed(other)) return ExchangeReason::failed;
  if (is_in_doubt(one) && !is_in_doubt(other)) return ExchangeReason::in_doubt;
  return ExchangeReason::none;
}

// The first part of a trial is the candidate's warming up: what no sensor sees was guessed. After the exchange both
// are warm, but a few readings judge nothing.
constexpr double settling_share_of_trial = 0.5;
constexpr double settling_share_of_watch = 0.1;

}  // namespace

void NetworkExchange::tell(ExchangeState state, ExchangeReason reason, bool candidate_is_shown) {
  state_ = state;
  const double shown_K = score_.running_K();
  const double beside_K = score_.beside_K();
  news_.write({state, reason, candidate_is_shown ? beside_K : shown_K, candidate_is_shown ? shown_K : beside_K});
}

void NetworkExchange::refuse(ExchangeReason reason) {
  beside_ = nullptr;
  tell(ExchangeState::refused, reason, false);
}

void NetworkExchange::listen() {
  const std::uint32_t refused = refused_files_.load(std::memory_order_acquire);
  // A file that was refused beside a candidate is in the log alone: the state is the candidate's.
  const bool is_new = std::exchange(refused_seen_, refused) != refused;
  if (is_new && beside_ == nullptr) state_ = ExchangeState::refused;
  if (Cycle* const offered = offered_.exchange(nullptr, std::memory_order_acquire)) {
    withdrawn_.store(false, std::memory_order_relaxed);
    confirmed_.store(false, std::memory_order_relaxed);
    beside_ = offered;
    beside_->begin_beside(*shown_);
    score_.clear();
    judged_s_ = 0.0;
    settled_s_ = settling_share_of_trial * plan_.trial_s;
    tell(ExchangeState::trial, ExchangeReason::none, false);
  }
  if (beside_ == nullptr) return;
  if (to_be_kept_ && confirmed_.load(std::memory_order_acquire)) {
    kept_ = shown_;
    kept_changed_ = true;
    beside_ = nullptr;
    to_be_kept_ = false;
    tell(ExchangeState::accepted, ExchangeReason::none, true);
    return;
  }
  if (!withdrawn_.exchange(false, std::memory_order_acquire)) return;
  if (state_ == ExchangeState::trial) return refuse(ExchangeReason::withdrawn);
  go_back(ExchangeReason::withdrawn);
}

void NetworkExchange::show_other() {
  const Cycle& before = *shown_;
  const bool goes_back = beside_ == kept_;
  std::swap(shown_, beside_);
  shown_->take_over(before, goes_back ? Cycle::TareOf::itself : Cycle::TareOf::other);
}

void NetworkExchange::step_beside(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
                                  std::int64_t missed) {
  try {
    beside_snapshot_ = beside_->step(frame, command, now_ns, missed);
  } catch (const std::exception&) {
    // The old one has never thrown; a candidate that does is not tried any further.
    if (beside_ != kept_) refuse(ExchangeReason::failed);
    return;
  }
  if (!score_.add(snapshot_, beside_snapshot_)) return;
  judged_s_ += advanced_s_;
  if (settled_s_ > 0.0 && judged_s_ >= settled_s_) {
    score_.clear();
    settled_s_ = 0.0;
  }
}

void NetworkExchange::step_shown(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
                                 std::int64_t missed) {
  if (beside_ == nullptr || shown_ == kept_) {
    snapshot_ = shown_->step(frame, command, now_ns, missed);
    return;
  }
  try {
    snapshot_ = shown_->step(frame, command, now_ns, missed);
  } catch (const std::exception&) {
    go_back(ExchangeReason::failed);
    snapshot_ = shown_->step(frame, command, now_ns, missed);
  }
}

void NetworkExchange::go_back(ExchangeReason reason) {
  show_other();
  beside_ = nullptr;  // from here on the candidate is not touched: it may be gone as soon as the other thread hears
  to_be_kept_ = false;
  tell(ExchangeState::went_back, reason, true);
}

void NetworkExchange::judge_trial() {
  const ExchangeReason trouble = trouble_of(beside_snapshot_, snapshot_);
  if (trouble == ExchangeReason::failed) return refuse(trouble);
  if (settled_s_ > 0.0) return;
  if (trouble != ExchangeReason::none) return refuse(trouble);
  if (judged_s_ < plan_.trial_s) return;
  if (score_.is_beside_worse(plan_)) return refuse(ExchangeReason::worse);
  tell(ExchangeState::watching, ExchangeReason::none, false);
  show_other();
  score_.clear();
  judged_s_ = 0.0;
  settled_s_ = settling_share_of_watch * plan_.watch_s;
}

void NetworkExchange::judge_watch() {
  ExchangeReason reason = trouble_of(snapshot_, beside_snapshot_);
  if (settled_s_ == 0.0 && reason == ExchangeReason::none && score_.is_running_worse(plan_)) {
    reason = ExchangeReason::worse;
  }
  if (reason == ExchangeReason::none) {
    if (to_be_kept_ || judged_s_ < plan_.watch_s) return;
    to_be_kept_ = true;  // the thread that looks at the slot writes the file, then confirms
    tell(ExchangeState::keeping, ExchangeReason::none, true);
    return;
  }
  if (confirmed_.load(std::memory_order_acquire)) return;  // it is on the disk already: accepted with the next cycle
  go_back(reason);
}

const Snapshot& NetworkExchange::step(const DeviceFrame& frame, const PlcCommand& command, std::int64_t now_ns,
                                      std::int64_t missed) {
  listen();
  const double before_s = snapshot_.model_time_s;
  step_shown(frame, command, now_ns, missed);
  advanced_s_ = snapshot_.model_time_s - before_s;
  if (beside_ != nullptr) step_beside(frame, command, now_ns, missed);
  if (beside_ != nullptr) {
    if (state_ == ExchangeState::trial) {
      judge_trial();
    } else {
      judge_watch();
    }
  }
  publish();
  return snapshot_;
}

void NetworkExchange::publish() {
  ExchangeView& view = snapshot_.exchange;
  view.state = state_;
  if (beside_ != nullptr) {
    const bool candidate_is_shown = shown_ != kept_;
    view.running_K = candidate_is_shown ? score_.beside_K() : score_.running_K();
    view.candidate_K = candidate_is_shown ? score_.running_K() : score_.beside_K();
    const double lasts_s = state_ == ExchangeState::trial ? plan_.trial_s : plan_.watch_s;
    view.left_s = std::max(0.0, lasts_s - judged_s_);
  } else {
    view.running_K = view.candidate_K = view.left_s = not_a_value;
  }
  newest_.write(snapshot_);
}

void NetworkExchange::note_troubles(const Troubles& troubles) {
  shown_->note_troubles(troubles);
  if (beside_ != nullptr) beside_->note_troubles(troubles);
}

}  // namespace spindle_twin::firmware
