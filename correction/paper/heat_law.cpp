#include "correction/paper/heat_law.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spindle_twin::correction {

HeatLaw::HeatLaw(HeatGroup members) : members_(std::move(members)) {
  measured_K_ = model_K_ = zero_K_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(members_.key_points.size()));
}

void HeatLaw::stand_by() {
  factor_ = step_ = ratio_ = 1.0;
  rise_K_ = 0.0;
  freeze_ = Freeze::waiting;
}

bool HeatLaw::correct(const PaperOptions& options, const MeasuringWindow& window, const BaseResponse& base,
                      const HeatInstant& instant) {
  step_ = 1.0;
  ratio_ = 1.0;
  rise_K_ = 0.0;
  freeze_ = judge(options, window, base, instant);
  return freeze_ == Freeze::none && step_ != 1.0;
}

Freeze HeatLaw::judge(const PaperOptions& options, const MeasuringWindow& window, const BaseResponse& base,
                      const HeatInstant& instant) {
  const PaperGuards& guards = options.guards;
  if (base.failed()) return Freeze::base_failed;
  if (std::abs(instant.speed_rpm) < guards.standstill_rpm) return Freeze::standstill;
  if (instant.settled_s < guards.settle_s - time_slack_s) return Freeze::operating_changed;
  const Eigen::Index sensors = gather(options.form, window, base, instant);
  const auto wanted =
      std::min<Eigen::Index>(guards.minimum_sensors, static_cast<Eigen::Index>(members_.key_points.size()));
  if (sensors < wanted) return Freeze::too_few_sensors;
  if (const Freeze freeze = judge_ratio(options, sensors); freeze != Freeze::none) return freeze;
  return move(options.relaxation, guards);
}

Eigen::Index HeatLaw::gather(RatioForm form, const MeasuringWindow& window, const BaseResponse& base,
                             const HeatInstant& instant) {
  Eigen::Index count = 0;
  for (const int key_point : members_.key_points) {
    if (!window.is_complete(key_point)) continue;
    measured_K_[count] = window.measured_K(key_point);
    model_K_[count] = window.predicted_K(key_point);
    switch (form) {
      case RatioForm::consistent:
        zero_K_[count] = base.mean_K(key_point, window.samples());
        break;
      case RatioForm::as_printed_eq3:
        zero_K_[count] = instant.ambient_K;
        break;
      default:
        zero_K_[count] = instant.start_K[key_point];
    }
    ++count;
  }
  return count;
}

Freeze HeatLaw::judge_ratio(const PaperOptions& options, Eigen::Index sensors) {
  const PaperGuards& guards = options.guards;
  const RiseRatio found =
      rise_ratio(options.form, measured_K_.head(sensors), model_K_.head(sensors), zero_K_.head(sensors));
  rise_K_ = found.model_rise_K;
  const double smallest_K = std::max(10.0 * guards.reading_uncertainty_K, guards.minimum_rise_K);
  if (std::abs(found.model_rise_K) < smallest_K || std::abs(found.measured_rise_K) < smallest_K) {
    return Freeze::small_rise;
  }
  if (!std::isfinite(found.ratio)) return Freeze::negative_ratio;
  ratio_ = found.ratio;
  const bool additive = options.form == RatioForm::as_printed_additive;
  if (found.ratio < 0.0 || (found.ratio == 0.0 && !additive)) return Freeze::negative_ratio;
  if (guards.deadband &&
      std::abs(std::log(found.ratio)) < guards.reading_uncertainty_K / std::abs(found.measured_rise_K)) {
    return Freeze::deadband;
  }
  return Freeze::none;
}

Freeze HeatLaw::move(double relaxation, const PaperGuards& guards) {
  const double step = std::clamp(std::pow(ratio_, relaxation), guards.step_minimum, guards.step_maximum);
  const double factor = std::clamp(factor_ * step, guards.heat_minimum, guards.heat_maximum);
  if (factor == factor_) return Freeze::at_limit;
  step_ = factor / factor_;
  factor_ = factor;
  return Freeze::none;
}

}  // namespace spindle_twin::correction
