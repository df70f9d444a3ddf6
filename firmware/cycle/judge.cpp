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

bool is_fresh(const SignalPlan& plan, const Sensed& signal) {
  if (signal.silent) return false;
  return std::isfinite(signal.value) && (plan.stale_after_s == 0.0 || signal.age_s <= plan.stale_after_s);
}

bool is_plausible(const SignalPlan& plan, const Sensed& signal, double last, std::int64_t last_ns, double clock_rate) {
  if (signal.value < plan.min || signal.value > plan.max) return false;
  if (last_ns == 0 || std::isnan(last)) return true;
  // Its age counts too: a client that writes on change only does not tell the same value again.
  const double since_s = 1e-9 * static_cast<double>(signal.time_ns - last_ns) * clock_rate + signal.age_s;
  return !(std::abs(signal.value - last) > plan.most_per_s * since_s) || signal.value == last;
}

void judge_signal(const CyclePlan& plan, const SensedInputs& sensed, std::size_t s, Judgement& judgement) {
  const SignalPlan& of = plan.signals[s];
  const Sensed& signal = sensed.signals[s];
  const bool fresh = is_fresh(of, signal);
  if (fresh && is_plausible(of, signal, judgement.signals[s], judgement.believed_ns[s], plan.clock_rate)) {
    judgement.signals[s] = signal.value;
    judgement.believed_ns[s] = signal.time_ns;
    return;
  }
  const auto bit = static_cast<std::uint16_t>(1U << s);
  judgement.quality |= bits(Quality::signal_held);
  judgement.signals_held |= bit;
  if (fresh) judgement.signals_implausible |= bit;
}

constexpr std::size_t index_of(Signal signal) { return static_cast<std::size_t>(signal); }

std::optional<double> if_known(double value) { return std::isnan(value) ? std::nullopt : std::optional(value); }

}  // namespace

Judgement first_judgement(const CyclePlan& plan) {
  Judgement judgement;
  judgement.sensors.fill(SensorQuality::not_configured);
  for (std::size_t s = 0; s < signal_count; ++s) judgement.signals[s] = plan.signals[s].value;
  return judgement;
}

void judge(const CyclePlan& plan, const SensedInputs& sensed, Judgement& judgement) {
  judgement.quality = judgement.signals_held = judgement.signals_implausible = 0;
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
    judge_signal(plan, sensed, s, judgement);
  }
  if ((uses_device || judgement.configured > 0) && !sensed.device_connected) {
    judgement.quality |= bits(Quality::device_offline);
  }
}

void put_signal(const rom::Boundaries& boundaries, std::size_t s, double value, rom::OperatingState& operating) {
  if (s == index_of(Signal::speed)) operating.speed_rpm = value;
  if (s == index_of(Signal::load)) operating.load = value;
  if (s == index_of(Signal::current)) operating.current_A = if_known(value);
  if (s == index_of(Signal::power)) operating.power_W = if_known(value);
  if (s == index_of(Signal::coolant) || s == index_of(Signal::ambient)) {
    const bool is_coolant = s == index_of(Signal::coolant);
    for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
      const bool has_coolant = boundaries.environments[e].kind == rom::EnvironmentKind::coolant;
      if (has_coolant == is_coolant) operating.environment_K[static_cast<Eigen::Index>(e)] = value;
    }
  }
  const auto circuit = static_cast<Eigen::Index>(s) - static_cast<Eigen::Index>(first_flow_signal);
  if (circuit >= 0 && circuit < operating.flow_kg_per_s.size()) operating.flow_kg_per_s[circuit] = value;
  const auto heat = static_cast<Eigen::Index>(s) - static_cast<Eigen::Index>(first_heat_signal);
  if (heat >= 0 && heat < operating.heat_W.size()) operating.heat_W[heat] = value;
}

void set_operating(const rom::Network& network, const Judgement& judgement, rom::OperatingState& operating) {
  for (std::size_t s = 0; s < signal_count; ++s) {
    put_signal(network.boundaries, s, judgement.signals[s], operating);
  }
}

}  // namespace spindle_twin::firmware
