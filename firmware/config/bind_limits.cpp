#include "firmware/config/bind_limits.hpp"

#include <algorithm>

#include "firmware/config/find_by_name.hpp"
#include "rom/boundary_values/plausible_inputs.hpp"

namespace spindle_twin::firmware {
namespace {

constexpr double coolant_K_per_s = 2.0;
constexpr double ambient_K_per_s = 0.5;
constexpr double most_rise_K = 200.0;

/// Narrower than what the plan allows so far.
void keep_within(const rom::Range& believed, SignalPlan& plan) {
  plan.min = std::max(plan.min, believed.min);
  plan.max = std::min(plan.max, believed.max);
}

void limit_surrounding(const rom::Boundaries& boundaries, const rom::PlausibleInputs& believed,
                       rom::EnvironmentKind kind, double K_per_s, SignalPlan& plan) {
  plan.most_per_s = K_per_s;
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    if (boundaries.environments[e].kind != kind) continue;
    keep_within(believed.environment_K[e], plan);
    return;
  }
}

void limit_by_network(std::size_t signal, const rom::Network& network, SignalPlan& plan) {
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::PlausibleInputs believed = rom::plausible_inputs(boundaries, network.certificate.box.speed_high_rpm);
  if (signal == static_cast<std::size_t>(Signal::speed)) {
    keep_within(believed.speed_rpm, plan);
  } else if (signal == static_cast<std::size_t>(Signal::load)) {
    keep_within(believed.load, plan);
  } else if (signal == static_cast<std::size_t>(Signal::coolant)) {
    limit_surrounding(boundaries, believed, rom::EnvironmentKind::coolant, coolant_K_per_s, plan);
  } else if (signal == static_cast<std::size_t>(Signal::ambient)) {
    limit_surrounding(boundaries, believed, rom::EnvironmentKind::ambient, ambient_K_per_s, plan);
  } else if (signal >= first_flow_signal && signal < first_heat_signal) {
    keep_within(believed.flow_kg_per_s[signal - first_flow_signal], plan);
  } else if (signal >= first_heat_signal && signal - first_heat_signal < believed.heat_W.size()) {
    keep_within(believed.heat_W[signal - first_heat_signal], plan);
  }
}

}  // namespace

void limit_signal(const ConfiguredSignal& configured, std::size_t signal, const rom::Network& network,
                  SignalPlan& plan) {
  if (plan.source != SignalSource::device && plan.source != SignalSource::plc) return;
  const SignalPlan widest = plan;
  limit_by_network(signal, network, plan);
  if (configured.min || configured.max) {
    plan.min = configured.min.value_or(std::min(plan.min, configured.max.value_or(plan.max)));
    plan.max = configured.max.value_or(std::max(plan.max, plan.min));
    plan.min = std::max(plan.min, widest.min);
    plan.max = std::min(plan.max, widest.max);
  }
  plan.most_per_s = configured.most_per_s.value_or(plan.most_per_s);
}

void limit_outputs(const Config& config, const rom::Network& network, CyclePlan& plan) {
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    plan.output_limit_m[d] = most_rise_K * network.deformations[d].row_m_per_K.lpNorm<1>();
  }
  for (const ConfiguredLimit& limit : config.output_limits) {
    if (limit.output.empty()) {
      plan.output_limit_m.fill(limit.limit_m);
    } else {
      const std::size_t d =
          find_by_name(network.deformations, limit.output, "deformation output", limit.where, limit.field);
      plan.output_limit_m[d] = limit.limit_m;
    }
  }
}

}  // namespace spindle_twin::firmware
