#include "correction/estimator/check_options.hpp"

#include "correction/estimator/estimator_correction.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/options.hpp"

namespace spindle_twin::correction {

EstimatorOptions checked(const rom::Network& network, EstimatorOptions options) {
  if (options.sensors.empty()) options.sensors = key_point_sensors(network, options);
  if (options.sensors.empty()) throw rom::InputError({}, "sensors", "the estimator needs at least one");
  EstimatorOptions::each(options, rom::CheckOptions());
  for (const EstimatorSensor& sensor : options.sensors) {
    const rom::CheckOptions check(sensor.name + ".");
    check({"noise_K", "", noise_range_K}, sensor.noise_K);
    check({"offset_K", "", offset_range_K}, sensor.offset_deviation_K);
    check({"lag_s", "", lag_range_s}, sensor.lag_s);
    if (sensor.row.size() != network.capacity_J_per_K.rows()) {
      throw rom::InputError({}, sensor.name + ".row", "must have one entry per node");
    }
  }
  return options;
}

}  // namespace spindle_twin::correction
