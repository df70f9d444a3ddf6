#include "firmware/cycle/judge.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::firmware {
namespace {

SensorQuality judge_sensor(const SensorPlan& plan, const Sensed& sensed) {
  if (!plan.configured) return SensorQuality::not_configured;
  if (std::isinf(sensed.age_s)) return SensorQuality::never_read;
  if (!std::isfinite(sensed.value)) return SensorQuality::not_finite;
  if (sensed.value < plan.min_K || sensed.value > plan.max_K) return SensorQuality::out_of_range;
  if (sensed.age_s > plan.stale_after_s) return SensorQuality::stale;
  return SensorQuality::good;
}

std::uint16_t quality_of(SensorQuality sensor) {
  switch (sensor) {
    case SensorQuality::never_read:
    case SensorQuality::not_finite:
      return bits(Quality::sensor_missing);
    case SensorQuality::stale:
      return bits(Quality::sensor_stale);
    case SensorQuality::out_of_range:
      return bits(Quality::sensor_out_of_range);
    default:
      return 0;
  }
}

bool believed(const SignalPlan& plan, const Sensed& sensed) {
  return std::isfinite(sensed.value) && sensed.value >= plan.min && sensed.value <= plan.max &&
         (plan.stale_after_s == 0.0 || sensed.age_s <= plan.stale_after_s);
}

std::optional<double> if_known(double value) { return std::isnan(value) ? std::nullopt : std::optional(value); }

}  // namespace

Judgement first_judgement(const CyclePlan& plan) {
  Judgement judgement;
  judgement.sensors.fill(SensorQuality::not_configured);
  for (std::size_t s = 0; s < signal_count; ++s) judgement.signals[s] = plan.signals[s].value;
  return judgement;
}

void judge(const CyclePlan& plan, const SensedInputs& sensed, Judgement& judgement) {
  judgement.quality = 0;
  judgement.configured = 0;
  judgement.good = 0;
  judgement.data_age_s = not_a_value;
  bool uses_device = false;
  for (std::size_t k = 0; k < plan.sensors.size(); ++k) {
    const SensorQuality quality = judge_sensor(plan.sensors[k], sensed.sensors[k]);
    judgement.sensors[k] = quality;
    judgement.quality |= quality_of(quality);
    if (plan.sensors[k].configured) ++judgement.configured;
    if (quality != SensorQuality::good) continue;
    ++judgement.good;
    judgement.data_age_s = std::fmax(judgement.data_age_s, sensed.sensors[k].age_s);
  }
  for (std::size_t s = 0; s < signal_count; ++s) {
    if (plan.signals[s].source == SignalSource::none) continue;
    uses_device = uses_device || plan.signals[s].source == SignalSource::device;
    if (believed(plan.signals[s], sensed.signals[s])) {
      judgement.signals[s] = sensed.signals[s].value;
    } else {
      judgement.quality |= bits(Quality::signal_held);
    }
  }
  if ((uses_device || judgement.configured > 0) && !sensed.device_connected) {
    judgement.quality |= bits(Quality::device_offline);
  }
}

void set_operating(const rom::Network& network, const Judgement& judgement, rom::OperatingState& operating) {
  const auto signal = [&](Signal which) { return judgement.signals[static_cast<std::size_t>(which)]; };
  operating.speed_rpm = signal(Signal::speed);
  operating.load = signal(Signal::load);
  operating.current_A = if_known(signal(Signal::current));
  operating.power_W = if_known(signal(Signal::power));
  const auto& environments = network.boundaries.environments;
  for (std::size_t e = 0; e < environments.size(); ++e) {
    operating.environment_K[static_cast<Eigen::Index>(e)] =
        signal(environments[e].kind == rom::EnvironmentKind::coolant ? Signal::coolant : Signal::ambient);
  }
  for (Eigen::Index c = 0; c < operating.flow_kg_per_s.size(); ++c) {
    operating.flow_kg_per_s[c] = judgement.signals[first_flow_signal + static_cast<std::size_t>(c)];
  }
  for (Eigen::Index h = 0; h < operating.heat_W.size(); ++h) {
    operating.heat_W[h] = judgement.signals[first_heat_signal + static_cast<std::size_t>(h)];
  }
}

}  // namespace spindle_twin::firmware
