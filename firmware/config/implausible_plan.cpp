#include "firmware/config/implausible_plan.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "firmware/cycle/judge.hpp"
#include "rom/boundary_values/plausible_inputs.hpp"

namespace spindle_twin::firmware {
namespace {

/// Not current and power, of which a description says nothing.
bool has_range(std::size_t signal) {
  return signal != static_cast<std::size_t>(Signal::current) && signal != static_cast<std::size_t>(Signal::power);
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
    if (plan.signals[signal].source != SignalSource::constant || !has_range(signal)) continue;
    rom::OperatingState state = boundaries.operating;
    put_signal(boundaries, signal, plan.signals[signal].value, state);
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
