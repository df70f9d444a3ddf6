#include <algorithm>
#include <cmath>

#include "firmware/config/bind_limits.hpp"
#include "firmware/config/config.hpp"
#include "firmware/config/find_by_name.hpp"
#include "firmware/config/read_compensation.hpp"
#include "rom/boundary_values/held_law.hpp"

namespace spindle_twin::firmware {
namespace {

void check_room(const Config& config, const char* what, std::size_t has, std::size_t room) {
  if (has <= room) return;
  throw rom::InputError(
      config.network.where, config.network.field,
      "has " + std::to_string(has) + " " + what + ", the register map has room for " + std::to_string(room));
}

void check_network(const Config& config, const rom::Network& network) {
  check_room(config, "key points", network.key_points.size(), slots::key_points);
  check_room(config, "parts", network.parts.size(), slots::parts);
  check_room(config, "heat sources", network.boundaries.sources.size(), slots::sources);
  check_room(config, "contacts and films", network.boundaries.conductances.size(), slots::conductances);
  check_room(config, "deformation outputs", network.deformations.size(), slots::deformations);
  check_room(config, "coolant circuits", network.boundaries.circuits.size(), slots::circuits);
  check_room(config, "measured heats", rom::measured_heats(network.boundaries).size(), slots::heats);
  if (config.calibration && config.cycle.estimator) {
    check_fits(config.calibration->calibration, network, config.cycle.estimator->priors, config.calibration->path);
  }
}

/// Coolant and ambient are needed where the network has such a surrounding, and ambient where a tare counts from it.
void check_surroundings(const Config& config, const rom::Network& network) {
  const auto told = [&](Signal signal) {
    return config.signals[static_cast<std::size_t>(signal)].plan.source != SignalSource::none;
  };
  const auto missing = [&](const char* field, const std::string& why) {
    throw rom::InputError(config.signals_where, field, "this key is required: " + why);
  };
  for (const rom::Environment& environment : network.boundaries.environments) {
    const bool coolant = environment.kind == rom::EnvironmentKind::coolant;
    if (told(coolant ? Signal::coolant : Signal::ambient)) continue;
    missing(coolant ? "signals.coolant" : "signals.ambient",
            "the network's surrounding \"" + environment.name + "\" has this temperature");
  }
  if (config.cycle.tare_to_ambient && !told(Signal::ambient)) {
    missing("signals.ambient", "health.tare.reference = \"ambient\" counts from it");
  }
}

/// Tells the device where its channel goes.
void connect(const ConfiguredChannel& channel, Channel::Kind kind, std::size_t index, const std::string& name,
             SpindlePlan& plan) {
  plan.devices[channel.device].channels[channel.number] = {kind, index, name, channel.conversion, channel.filter};
}

/// One count of the device; a float tells nothing of its converter.
double resolution_K(const std::optional<ConfiguredChannel>& channel) {
  constexpr double of_a_float_K = 0.01;
  return channel && channel->step > 0.0 ? channel->step : of_a_float_K;
}

void bind_signal(const ConfiguredSignal& configured, std::size_t signal, const rom::Network& network,
                 SpindlePlan& plan) {
  plan.cycle.signals[signal] = configured.plan;
  limit_signal(configured, signal, network, plan.cycle.signals[signal]);
  if (configured.channel) connect(*configured.channel, Channel::Kind::signal, signal, configured.field, plan);
}

/// A signal that moves nothing would be a mistake that nobody sees.
void check_followed(const ConfiguredSignal& signal, bool followed, const std::string& law) {
  if (signal.plan.source == SignalSource::none || followed) return;
  throw rom::InputError(signal.where, signal.field,
                        "no heat of the network follows it; only those of the law \"" + law + "\" do");
}

void bind_flows(const Config& config, const rom::Network& network, SpindlePlan& plan) {
  const auto& circuits = network.boundaries.circuits;
  const Eigen::VectorXd& operating_kg_per_s = network.boundaries.operating.flow_kg_per_s;
  for (std::size_t c = 0; c < circuits.size(); ++c) {
    SignalPlan& flow = plan.cycle.signals[first_flow_signal + c];
    flow.source = SignalSource::constant;
    flow.value = operating_kg_per_s[static_cast<Eigen::Index>(c)];
  }
  for (const ConfiguredFlow& flow : config.flows) {
    ConfiguredSignal signal = flow.signal;
    if (circuits.empty()) throw rom::InputError(signal.where, signal.field, "the network has no coolant circuit");
    const std::size_t c = find_by_name(circuits, flow.circuit, "coolant circuit", signal.where, signal.field);
    if (!signal.has_first) signal.plan.value = operating_kg_per_s[static_cast<Eigen::Index>(c)];
    bind_signal(signal, first_flow_signal + c, network, plan);
  }
}

void bind_heats(const Config& config, const rom::Network& network, SpindlePlan& plan) {
  std::vector<rom::HeatSource> measured;
  for (const std::size_t heat : rom::measured_heats(network.boundaries)) {
    measured.push_back(network.boundaries.sources[heat]);
  }
  for (const ConfiguredHeat& heat : config.heats) {
    const ConfiguredSignal& signal = heat.signal;
    if (measured.empty()) throw rom::InputError(signal.where, signal.field, "the network has no measured heat");
    bind_signal(signal,
                first_heat_signal + find_by_name(measured, heat.heat, "measured heat", signal.where, signal.field),
                network, plan);
  }
}

/// Nodes that are not named start at the mean of those that are.
void bind_start(const Config& config, const rom::Network& network, CyclePlan& cycle) {
  if (config.start.empty()) return;
  double sum_K = 0.0;
  for (const ConfiguredStart& start : config.start) sum_K += start.temperature_K;
  cycle.start_temperature_K = sum_K / static_cast<double>(config.start.size());
  cycle.start_nodes_K =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()), *cycle.start_temperature_K);
  for (const ConfiguredStart& start : config.start) {
    const std::size_t node = find_by_name(network.nodes, start.node, "node", start.where, start.field);
    cycle.start_nodes_K[static_cast<Eigen::Index>(node)] = start.temperature_K;
  }
}

/// Groups of the published law: those of the configuration, or one of all sensors and heats.
void bind_groups(const Config& config, const rom::Network& network, CyclePlan& cycle) {
  for (const ConfiguredGroup& configured : config.groups) {
    correction::HeatGroup group{configured.name, {}, {}};
    for (const std::string& sensor : configured.sensors) {
      const std::size_t k = find_by_name(network.key_points, sensor, "key point", configured.where, configured.field);
      if (!cycle.sensors[k].configured) {
        throw rom::InputError(configured.where, configured.field, "key point \"" + sensor + "\" has no [[sensor]]");
      }
      const bool is_twice = std::count(configured.sensors.begin(), configured.sensors.end(), sensor) > 1;
      if (is_twice) {
        throw rom::InputError(configured.where, configured.field, "\"" + sensor + "\" stands there twice, but is one");
      }
      group.key_points.push_back(static_cast<int>(k));
    }
    for (const std::string& source : configured.sources) {
      group.sources.push_back(static_cast<int>(
          find_by_name(network.boundaries.sources, source, "heat source", configured.where, configured.field)));
    }
    cycle.paper->groups.push_back(group);
  }
  if (cycle.paper->groups.empty()) {
    correction::HeatGroup all = correction::common_heat_group(network).front();
    std::erase_if(all.key_points, [&](int k) { return !cycle.sensors[static_cast<std::size_t>(k)].configured; });
    cycle.paper->groups.push_back(all);
  }
}

}  // namespace

SpindlePlan bind_config(const Config& config, const rom::Network& network) {
  check_network(config, network);
  check_surroundings(config, network);
  SpindlePlan plan{config.cycle, config.devices};
  for (const ConfiguredSensor& sensor : config.sensors) {
    const std::size_t k = find_by_name(network.key_points, sensor.key_point, "key point", sensor.where, sensor.field);
    SensorPlan& slot = plan.cycle.sensors[k];
    if (slot.configured) {
      throw rom::InputError(sensor.where, sensor.field, "\"" + sensor.key_point + "\" has a sensor already");
    }
    slot = {true, sensor.min_degC + zero_degC_K, sensor.max_degC + zero_degC_K, sensor.stale_after_s};
    const correction::EstimatorOptions all = plan.cycle.estimator.value_or(correction::EstimatorOptions{});
    slot.noise_K = sensor.noise_K.value_or(all.noise_K);
    slot.offset_deviation_K = sensor.offset_deviation_K.value_or(all.offset_deviation_K);
    slot.lag_s = sensor.lag_s.value_or(all.lag_s);
    slot.interval_s = sensor.interval_s;
    slot.resolution_K = sensor.resolution_K.value_or(resolution_K(sensor.channel));
    if (sensor.channel) connect(*sensor.channel, Channel::Kind::sensor, k, sensor.key_point, plan);
  }
  for (const ConfiguredProbe& probe : config.probes) {
    const std::size_t d =
        find_by_name(network.deformations, probe.output, "deformation output", probe.where, probe.field);
    if (plan.cycle.probes[d].configured) {
      throw rom::InputError(probe.where, probe.field, "\"" + probe.output + "\" has a probe already");
    }
    plan.cycle.probes[d] = probe.plan;
    connect(probe.channel, Channel::Kind::displacement, d, probe.output, plan);
  }
  const auto signal = [&](Signal which) { return config.signals[static_cast<std::size_t>(which)]; };
  check_followed(signal(Signal::current), rom::follows_current(network.boundaries), "copper_loss");
  check_followed(signal(Signal::power), rom::follows_power(network.boundaries), "motor_efficiency");
  for (std::size_t s = 0; s < first_flow_signal; ++s) bind_signal(config.signals[s], s, network, plan);
  bind_flows(config, network, plan);
  bind_heats(config, network, plan);
  bind_start(config, network, plan.cycle);
  limit_outputs(config, network, plan.cycle);
  bind_compensation(config, network, plan.cycle);
  if (plan.cycle.paper) bind_groups(config, network, plan.cycle);
  return plan;
}

}  // namespace spindle_twin::firmware
