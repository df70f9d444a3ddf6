#include "host_tools/replay/plan.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "host_tools/replay/log_readings.hpp"
#include "rom/boundary_values/environments.hpp"

namespace spindle_twin::host_tools {
namespace {

using firmware::zero_degC_K;

std::string columns_of(const rom::Network& network, const Log& log) {
  std::string names;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (log.has_sensor[k]) names.append(names.empty() ? "" : ", ").append(network.key_points[k].name);
  }
  return names.empty() ? "none" : names;
}

/// The operating state's temperature of the first environment of a kind.
double operating_K(const rom::Boundaries& boundaries, rom::EnvironmentKind kind) {
  return rom::first_environment_K(boundaries, kind, boundaries.operating).value_or(boundaries.reference_temperature_K);
}

/// What a configuration for this log would say.
firmware::Config config_of_log(const rom::Network& network, const Log& log, const ReplayOptions& options) {
  firmware::Config config;
  config.network.path = config.network.where.file = options.network;
  config.cycle.period_s = options.period_s.value_or(log.cycle_s.value_or(config.cycle.period_s));
  std::vector<std::string> names = options.sensors;
  for (std::size_t k = 0; k < network.key_points.size() && options.sensors.empty(); ++k) {
    if (log.has_sensor[k]) names.push_back(network.key_points[k].name);
  }
  const double usual_noise_K = correction::EstimatorOptions{}.noise_K;
  for (const std::string& name : names) {
    firmware::ConfiguredSensor sensor;
    sensor.key_point = name;
    sensor.field = "--sensors";
    sensor.stale_after_s = options.longest_gap_s;
    const auto key_point = std::find_if(network.key_points.begin(), network.key_points.end(),
                                        [&](const rom::KeyPoint& point) { return point.name == name; });
    if (key_point != network.key_points.end()) {
      const auto slot = static_cast<std::size_t>(key_point - network.key_points.begin());
      sensor.resolution_K = resolution_of_log_K(log, slot);
      const double noise_K = std::min(noise_of_log_K(log, slot), correction::noise_range_K.max);
      if (noise_K > usual_noise_K) sensor.noise_K = noise_K;
    }
    config.sensors.push_back(sensor);
  }
  const std::array<double, 4> otherwise = {// speed, load, coolant, ambient
                                           network.boundaries.operating.speed_rpm, network.boundaries.operating.load,
                                           operating_K(network.boundaries, rom::EnvironmentKind::coolant),
                                           operating_K(network.boundaries, rom::EnvironmentKind::ambient)};
  for (std::size_t s = 0; s < otherwise.size(); ++s) {
    config.signals[s].plan = {firmware::SignalSource::constant, otherwise[s], -1e300, 1e300, options.longest_gap_s};
  }
  return config;
}

void choose_correction(const std::string& wanted, const std::string& calibration, firmware::Config& config) {
  if (wanted.empty() && !config.path.empty()) return;
  const std::string law = !wanted.empty() ? wanted : config.sensors.empty() ? "none" : "estimator";
  firmware::CyclePlan& cycle = config.cycle;
  const bool calibrated = config.calibration || !calibration.empty();
  cycle.estimator_corrects = law == "estimator" || (law == "none" && calibrated);
  if (law == "none" && calibrated) config.sensors.clear();  // what the calibrated model says by itself
  cycle.correction_enabled = true;
  if (law == "paper") {
    cycle.estimator.reset();
    if (!cycle.paper) cycle.paper.emplace();
  } else {
    cycle.paper.reset();
    if (!cycle.estimator) {
      correction::EstimatorOptions& options = cycle.estimator.emplace();
      options.period_s = std::max(options.period_s, cycle.period_s);
    }
  }
  if (law != "none" && config.sensors.empty()) {
    throw rom::InputError({}, "--correction", "\"" + law + "\" needs at least one sensor in the log");
  }
}

/// What the command line says of the estimator and of the sensors' health.
void apply_estimator_options(const rom::Network& network, const ReplayOptions& options, firmware::CyclePlan& cycle) {
  const std::pair<const char*, const std::optional<double>*> given[] = {{"--floor-K", &options.floor_K},
                                                                        {"--offset-K", &options.offset_deviation_K},
                                                                        {"--lag-s", &options.lag_s},
                                                                        {"--start-K", &options.start_K}};
  for (const auto& [name, value] : given) {
    if (*value && !cycle.estimator) throw rom::InputError({}, name, "is of the estimator; the published law has none");
  }
  if (cycle.estimator) {
    correction::EstimatorOptions& estimator = *cycle.estimator;
    estimator.floor_K = options.floor_K.value_or(estimator.floor_K);
    estimator.offset_deviation_K = options.offset_deviation_K.value_or(estimator.offset_deviation_K);
    estimator.lag_s = options.lag_s.value_or(estimator.lag_s);
    estimator.priors.start_K = options.start_K.value_or(estimator.priors.start_K);
  }
  if (options.health == "off") cycle.health.reset();
  if (options.calibration.empty()) return;
  if (!cycle.estimator) throw rom::InputError({}, "--calibration", "is of the estimator; the published law has none");
  const correction::Calibration calibration = correction::read_calibration(options.calibration);
  check_fits(calibration, network, cycle.estimator->priors, options.calibration);
  cycle.estimator->priors.calibrated = prior_of(calibration, {});
}

void check_sensors(const rom::Network& network, const firmware::CyclePlan& plan, const Log& log) {
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (!plan.sensors[k].configured || log.has_sensor[k]) continue;
    throw rom::InputError(
        {log.file, 1}, "measured." + network.key_points[k].name + "_degC",
        "this sensor is configured, but the log has no reading of it; it has: " + columns_of(network, log));
  }
}

}  // namespace

firmware::CyclePlan plan_replay(const rom::Network& network, const Log& log, const ReplayOptions& options) {
  if (!options.config.empty() && !options.sensors.empty()) {
    throw rom::InputError({}, "--sensors", "is of a replay without a configuration, which says what sensors there are");
  }
  firmware::Config config =
      options.config.empty() ? config_of_log(network, log, options) : firmware::read_spindle_config(options.config);
  choose_correction(options.correction, options.calibration, config);
  apply_estimator_options(network, options, config.cycle);
  firmware::CyclePlan plan = firmware::bind_config(config, network).cycle;
  check_sensors(network, plan, log);
  plan.compare_uncorrected = true;
  if (!log.cycle_s) plan.clock_rate = 1.0;  // a rehearsal's rate is none of a log's business
  if (options.start_degC) {
    plan.start_temperature_K = *options.start_degC + zero_degC_K;
    plan.start_nodes_K.resize(0);
  }
  if (!plan.start_temperature_K && config.sensors.empty()) plan.start_temperature_K = start_of_log_K(log);
  if (!plan.start_temperature_K && config.sensors.empty()) {
    throw rom::InputError({log.file, 1}, "--start-degC", "is needed where no sensor tells where to start from");
  }
  if (log.cycle_s && std::abs(plan.period_s - *log.cycle_s) > 1e-6) {
    throw rom::InputError({log.file, 0}, "time_s",
                          "this history has a cycle every " + std::to_string(*log.cycle_s) + " s, not every " +
                              std::to_string(plan.period_s) + " s");
  }
  return plan;
}

const char* law_of(const firmware::CyclePlan& plan) {
  if (plan.paper) return "paper";
  if (!plan.estimator || !plan.estimator_corrects) return "none";
  const bool reads = std::any_of(plan.sensors.begin(), plan.sensors.end(),
                                 [](const firmware::SensorPlan& sensor) { return sensor.configured; });
  return reads ? "estimator" : "calibration";
}

}  // namespace spindle_twin::host_tools
