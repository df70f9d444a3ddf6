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

// A spindle that nobody uses is as warm as its hall, and one that ran no warmer than grease bears.
constexpr rom::Range start_degC = rom::between(-20.0, 120.0);

void judge_start(double temperature_K, const rom::SourceLine& where, const std::string& field,
                 std::vector<rom::InputError>& found) {
  const auto said = rom::judge_value(temperature_K - zero_degC_K, start_degC, field, "degC, not kelvin");
  if (said) found.emplace_back(where, field, said->message);
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
    if (plan.signals[signal].source == SignalSource::none || !has_range(signal)) continue;
    const ConfiguredSignal& said = configured(config, boundaries, signal);
    const bool is_meant = said.min || said.max;  // the configuration says itself what is believed
    if (!said.has_first || is_meant) continue;
    rom::OperatingState state = boundaries.operating;
    put_signal(boundaries, signal, plan.signals[signal].value, state);
    const std::vector<rom::Implausible> of_signal = rom::implausible_inputs(boundaries, believed, state);
    if (of_signal.empty()) continue;
    found.emplace_back(said.where, said.field, of_signal.front().message);
  }
  if (config.start_where.line > 0) {
    judge_start(*config.cycle.start_temperature_K, config.start_where, "start.temperature_degC", found);
  }
  for (const ConfiguredStart& node : config.start) judge_start(node.temperature_K, node.where, node.field, found);
  for (const rom::Implausible& each : rom::implausible_description(boundaries, network.capacity_J_per_K.sum())) {
    found.emplace_back(rom::SourceLine{config.network.path, 0}, each.field, each.message);
  }
  return found;
}

}  // namespace spindle_twin::firmware
