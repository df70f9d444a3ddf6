#pragma once

#include <limits>

#include "firmware/cycle/compensation_trial.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

enum class OnLoss { hold, decay };

/// How a deformation becomes the value that the CNC adds to its axis.
struct CompensationPlan {
  bool enabled = true;         ///< until the PLC says otherwise
  double sign = 1.0;           ///< -1: the counter movement
  double slew_m_per_s = 5e-7;  ///< model time
  double step_m = 0.0;         ///< the value changes by no less; 0: any change
  double warning_m = std::numeric_limits<double>::infinity();
  double limit_m = std::numeric_limits<double>::infinity();  ///< the value stays within plus and minus this
  OnLoss on_loss = OnLoss::decay;
  double hold_s = 600.0;                    ///< how long the last value stays after a loss, before it decays
  double decay_s = 1800.0;                  ///< time constant of that
  std::size_t other = slots::deformations;  ///< output that the slope comes from; slots::deformations: none
  double distance_m = 0.0;                  ///< from the nose to that output along the axis
  double reference_m = 0.0;                 ///< the control's position at the nose
};

/// The value that the CNC adds, with its ladder of fallbacks: what the estimator says, with fewer sensors, the open
/// loop of speed and load, the last value held, the last value decaying to zero. Whatever happens, the value moves no
/// faster than the slew limit: neither a rung, an order nor a loss is a step for the machine.
///   wanted = sign · (nose − tare), within the limit; 0 while disabled
///   wanted = the value of a trial while there is one, also while disabled, within the limit too
///   value ← value + clamp(wanted − value, ± slew · advance), in whole steps of step_m
///   σ² = σ_nose² + (wanted − value)²; not known once the prediction is lost
///   slope = sign · (d_other − d_nose) / distance: control: value + slope · (position − reference)
/// The bit `trial` is up until the value is back from one. All functions may run in the cycle.
class Compensation {
 public:
  explicit Compensation(const CompensationPlan& plan) : plan_(plan) {}

  /// Before the first step, where a run before is gone on from: the value begins where it is wanted, as the published
  /// nose does, and as far away from there as a trial had taken it. The control has followed it there, and a way from 0
  /// on would be a step for the machine.
  void begin_at(const Snapshot& snapshot);

  /// Switching off ends a trial.
  void order(SwitchOrder order);
  SwitchOrder ordered() const { return order_; }

  /// Refused where the value is beyond the limit; none where nothing new was ordered. now_s: of the clock.
  OrderResult try_value(const TrialOrder& trial, double now_s);
  /// How far a trial, or the way back from it, has the value from where it is wanted otherwise, in m; else 0.
  double away_m() const { return is_tried_ ? value_m_ - normal_m_ : 0.0; }
  /// Before begin_at(): what away_m() said at the end of a run before.
  void resume_away(double away_m) { begins_away_m_ = away_m; }

  /// gap_s of model time in which no cycle ran: a loss goes on, the value stays where it is.
  void pass(double gap_s) {
    if (lost_s_ > 0.0) lost_s_ += gap_s;
  }

  /// After all else of the cycle is in the snapshot, advance_s of model time after the last one. `good`, `configured`:
  /// how many sensors are in use, and how many there are.
  void step(std::size_t good, std::size_t configured, double advance_s, Snapshot& snapshot);

 private:
  bool enabled() const { return order_ == SwitchOrder::as_configured ? plan_.enabled : order_ == SwitchOrder::on; }
  Rung rung_of(std::size_t good, std::size_t configured, const Snapshot& snapshot) const;
  void follow(double wanted_m, double advance_s);

  CompensationPlan plan_;
  SwitchOrder order_ = SwitchOrder::as_configured;
  CompensationTrial trial_;
  std::uint32_t trial_orders_ = 0;
  std::uint32_t trial_renewals_ = 0;
  bool is_tried_ = false;  ///< there is a trial, or the way back from it
  double begins_away_m_ = 0.0;
  double normal_m_ = 0.0;     ///< wanted without a trial
  double value_m_ = 0.0;      ///< on its way
  double published_m_ = 0.0;  ///< in whole steps
  double last_m_ = 0.0;       ///< wanted, before the loss
  double lost_s_ = 0.0;       ///< since the loss
  bool has_predicted_ = false;
};

}  // namespace spindle_twin::firmware
