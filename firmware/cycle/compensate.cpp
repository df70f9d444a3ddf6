#include "firmware/cycle/compensate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spindle_twin::firmware {
namespace {

/// Without speed and load there is no open loop; bits of Snapshot::signals_held.
constexpr auto drive_signals =
    static_cast<std::uint16_t>(1U << static_cast<unsigned>(Signal::speed) | 1U << static_cast<unsigned>(Signal::load));

}  // namespace

Rung Compensation::rung_of(std::size_t good, std::size_t configured, const Snapshot& snapshot) const {
  const bool predicts = snapshot.state == State::running || snapshot.state == State::degraded;
  const bool corrects = snapshot.correction_enabled && good > 0;
  if (predicts && corrects) return good == configured ? Rung::estimator : Rung::fewer_sensors;
  if (predicts && (snapshot.signals_held & drive_signals) == 0) return Rung::open_loop;
  if (!has_predicted_) return Rung::none;
  return plan_.on_loss == OnLoss::hold || lost_s_ < plan_.hold_s ? Rung::hold : Rung::decay;
}

void Compensation::begin_at(const Snapshot& snapshot) {
  if (!std::isfinite(snapshot.nose_m)) return;
  last_m_ = plan_.sign * snapshot.nose_m;
  has_predicted_ = true;
  normal_m_ = enabled() ? std::clamp(last_m_, -plan_.limit_m, plan_.limit_m) : 0.0;
  value_m_ = std::clamp(normal_m_ + begins_away_m_, -plan_.limit_m, plan_.limit_m);
  is_tried_ = begins_away_m_ != 0.0;
  published_m_ = plan_.step_m > 0.0 ? plan_.step_m * std::round(value_m_ / plan_.step_m) : value_m_;
}

void Compensation::order(SwitchOrder order) {
  if (order == SwitchOrder::off && order_ != SwitchOrder::off) trial_.end();
  order_ = order;
}

OrderResult Compensation::try_value(const TrialOrder& trial, double now_s) {
  if (std::exchange(trial_renewals_, trial.renewals) != trial.renewals) trial_.renew(now_s);
  if (std::exchange(trial_orders_, trial.orders) == trial.orders) return OrderResult::none;
  if (std::isnan(trial.value_m)) {
    trial_.end();
    return OrderResult::done;
  }
  if (!(std::abs(trial.value_m) <= plan_.limit_m)) return OrderResult::refused;
  trial_.begin(trial.value_m, now_s);
  return OrderResult::done;
}

void Compensation::follow(double wanted_m, double advance_s) {
  const double most_m = plan_.slew_m_per_s * advance_s;
  value_m_ += std::clamp(wanted_m - value_m_, -most_m, most_m);
  if (std::abs(value_m_ - published_m_) < plan_.step_m) return;
  published_m_ = plan_.step_m > 0.0 ? plan_.step_m * std::round(value_m_ / plan_.step_m) : value_m_;
}

void Compensation::step(std::size_t good, std::size_t configured, double advance_s, Snapshot& snapshot) {
  CompensationState& told = snapshot.compensation;
  told = {};
  if (snapshot.deformations == 0) return;
  const Rung rung = rung_of(good, configured, snapshot);
  const bool live = rung == Rung::estimator || rung == Rung::fewer_sensors || rung == Rung::open_loop;
  if (live) {
    last_m_ = plan_.sign * snapshot.nose_m;
    lost_s_ = 0.0;
    has_predicted_ = true;
  } else if (has_predicted_) {
    lost_s_ += advance_s;
  }
  const double kept = rung == Rung::decay ? std::exp(-(lost_s_ - plan_.hold_s) / plan_.decay_s) : 1.0;
  const double limited_m = std::clamp(kept * last_m_, -plan_.limit_m, plan_.limit_m);
  normal_m_ = enabled() ? limited_m : 0.0;
  const double now_s = 1e-9 * static_cast<double>(snapshot.clock_ns);
  const double tried_m = trial_.value_m(now_s);
  const bool tries = !std::isnan(tried_m);
  const double wanted_m = tries ? tried_m : normal_m_;
  follow(wanted_m, advance_s);
  is_tried_ = tries || (is_tried_ && value_m_ != normal_m_);

  told.rung = rung;
  told.value_m = published_m_;
  told.age_s = lost_s_;
  if (live && enabled() && !tries) {
    told.deviation_m = std::hypot(snapshot.deformation_deviation_m[0], published_m_ - wanted_m);
  }
  if (is_tried_) told.bits |= bits(CompensationBit::trial);
  if (is_tried_) told.trial_left_s = tries ? trial_.left_s(now_s) : 0.0;
  if (enabled()) told.bits |= bits(CompensationBit::enabled);
  if (std::abs(kept * last_m_) > plan_.warning_m) told.bits |= bits(CompensationBit::warning);
  if (std::abs(kept * last_m_) > plan_.limit_m) told.bits |= bits(CompensationBit::limited);
  if (value_m_ != wanted_m) told.bits |= bits(CompensationBit::moving);
  told.reference_m = plan_.reference_m;
  if (plan_.other >= snapshot.deformations) {
    told.slope = 0.0;
  } else if (live) {
    const double along_m = snapshot.deformation_m[plan_.other] - snapshot.deformation_m[0];
    told.slope = enabled() ? plan_.sign * along_m / plan_.distance_m : 0.0;
  }
}

}  // namespace spindle_twin::firmware
