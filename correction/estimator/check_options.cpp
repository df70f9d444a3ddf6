#include "correction/estimator/check_options.hpp"

#include <cmath>

#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

void between(double value, double low, double high, const std::string& field) {
  if (std::isfinite(value) && value >= low && value <= high) return;
  std::string text = "must be between ";
  text.append(std::to_string(low)).append(" and ").append(std::to_string(high));
  throw rom::InputError({}, field, text);
}

}  // namespace

EstimatorOptions checked(const rom::Network& network, EstimatorOptions options) {
  if (options.sensors.empty()) options.sensors = key_point_sensors(network, options);
  if (options.sensors.empty()) throw rom::InputError({}, "sensors", "the estimator needs at least one");
  between(options.period_s, 1.0, 60.0, "period_s");
  between(options.floor_K, 0.0, 10.0, "floor_K");
  between(options.floor_by_hand_K, 0.0, 10.0, "floor_by_hand_K");
  between(options.floor_largest_K, 0.0, 100.0, "floor_largest_K");
  between(options.lag_deviation_s, 0.0, 120.0, "lag_deviation_s");
  between(options.curvature, 0.0, 100.0, "curvature");
  between(options.correlation_s, 0.0, 3600.0, "correlation_s");
  between(options.offset_walk_K_per_root_hour, 0.0, 1.0, "offset_walk_K_per_root_hour");
  between(options.gate, 1.0, 1000.0, "gate");
  for (const EstimatorSensor& sensor : options.sensors) {
    between(sensor.noise_K, 1e-4, 10.0, sensor.name + ".noise_K");
    between(sensor.offset_K, 1e-4, 10.0, sensor.name + ".offset_K");
    between(sensor.lag_s, 0.0, 600.0, sensor.name + ".lag_s");
    if (sensor.row.size() != network.capacity_J_per_K.rows()) {
      throw rom::InputError({}, sensor.name + ".row", "must have one entry per node");
    }
  }
  return options;
}

}  // namespace spindle_twin::correction
