#include "host_tools/calibrate/test_options.hpp"

#include "correction/estimator/estimator_correction.hpp"
#include "firmware/config/config.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr double no_lag_s = 1e-3;  // 1σ of what is known

}  // namespace

correction::CalibrateOptions test_options(const rom::Network& network, const std::string& config_file) {
  correction::CalibrateOptions options;
  correction::EstimatorOptions estimator;
  if (config_file.empty()) {
    options.sensors = correction::key_point_sensors(network, estimator);
  } else {
    const firmware::Config config = firmware::read_spindle_config(config_file);
    if (!config.cycle.estimator) {
      throw rom::InputError({config_file, 0}, "correction.law",
                            "must be \"estimator\": a calibration is of its parameters");
    }
    estimator = *config.cycle.estimator;
    options.sensors = correction::key_point_sensors(network, estimator);
    const firmware::CyclePlan plan = firmware::bind_config(config, network).cycle;
    for (std::size_t k = 0; k < options.sensors.size(); ++k) {
      const firmware::SensorPlan& sensor = plan.sensors[k];
      if (!sensor.configured) continue;
      options.sensors[k].noise_K = sensor.noise_K;
      options.sensors[k].offset_deviation_K = sensor.offset_deviation_K;
      options.sensors[k].lag_s = sensor.lag_s;
    }
  }
  options.priors = correction::test_priors(estimator.priors);
  options.lag_deviation_s = estimator.lag_deviation_s > 0.0 ? estimator.lag_deviation_s : no_lag_s;
  return options;
}

}  // namespace spindle_twin::host_tools
