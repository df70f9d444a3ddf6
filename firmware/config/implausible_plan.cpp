#include "firmware/config/implausible_plan.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "rom/boundary_values/plausible_inputs.hpp"

namespace spindle_twin::firmware {
namespace {

/// Puts one signal's constant into the state; false where no value of a description stands against it.
bool set_signal(const rom::Boundaries& boundaries, std::size_t signal, double value, rom::OperatingState& state) {
  if (signal == static_cast<std::size_t>(Signal::speed)) {
    state.speed_rpm = value;
  } else if (signal == static_cast<std::size_t>(Signal::load)) {
    state.load = value;
  } else if (signal == static_cast<std::size_t>(Signal::coolant) ||
             signal == static_cast<std::size_t>(Signal::ambient)) {
    const auto kind = signal == static_cast<std::size_t>(Signal::coolant) ? rom::EnvironmentKind::coolant
                                                                          : rom::EnvironmentKind::ambient;
    for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
      if (boundaries.environments[e].kind == kind) state.environment_K[static_cast<Eigen::Index>(e)] = value;
    }
  } else if (signal >= first_flow_signal && signal < first_heat_signal) {
    state.flow_kg_per_s[static_cast<Eigen::Index>(signal - first_flow_signal)] = value;
  } else {
    return false;
  }
  return true;
}

/// Where the configuration has the signal.
const ConfiguredSignal& configured(const Config& config, const rom::Boundaries& boundaries, std::size_t signal) {
  if (signal < first_flow_signal) return config.signals[signal];
  const std::string& circuit = boundaries.circuits[signal - first_flow_signal].name;
  return std::find_if(config.flows.begin(), config.flows.end(),
                      [&](const ConfiguredFlow& flow) { return flow.circuit == circuit; })
      ->signal;
}

}  // namespace

std::vector<rom::InputError> implausible_plan(const Config& config, const rom::Network& network,
                                              const CyclePlan& plan) {
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::PlausibleInputs believed = rom::plausible_inputs(boundaries, network.certificate.box.speed_high_rpm);
  std::vector<rom::InputError> found;
  for (std::size_t signal = 0; signal < first_heat_signal; ++signal) {
    if (plan.signals[signal].source != SignalSource::constant) continue;
    rom::OperatingState state = boundaries.operating;
    if (!set_signal(boundaries, signal, plan.signals[signal].value, state)) continue;
    const std::vector<rom::Implausible> of_signal = rom::implausible_inputs(boundaries, believed, state);
    if (of_signal.empty()) continue;
    const ConfiguredSignal& said = configured(config, boundaries, signal);
    found.emplace_back(said.where, said.field, of_signal.front().message);
  }
  for (const rom::Implausible& each : rom::implausible_description(boundaries, network.capacity_J_per_K.sum())) {
    found.emplace_back(rom::SourceLine{config.network.path, 0}, each.field, each.message);
  }
  return found;
}

}  // namespace spindle_twin::firmware
