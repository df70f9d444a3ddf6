#include "firmware/config/expect_of_sensors.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "correction/identify/identify.hpp"
#include "firmware/keep/parameters.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {

std::string expect_of_sensors(const rom::Network& network, const CyclePlan& plan) {
  if (!plan.estimator || !plan.estimator_corrects || network.deformations.empty()) return {};
  using rom::um_per_m;
  const correction::EstimatorOptions& estimator = *plan.estimator;
  correction::IdentifyOptions options;
  options.priors = estimator.priors;
  // From a cold start, and as long as nothing speaks for a heat that no source explains.
  options.priors.start_shape_K = options.priors.disturbance = options.priors.disturbance_by_hand = 0.0;
  options.sample_s = estimator.period_s;
  options.floor_K = estimator.floor_K;
  options.correlation_s = estimator.correlation_s;
  options.placements = 0;
  options.noise_K = options.offset_deviation_K = 0.0;
  std::vector<correction::SensorPlace> sensors;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (!plan.sensors[k].configured) continue;
    const rom::KeyPoint& point = network.key_points[k];
    sensors.push_back({point.name, point.part, point.r_m, point.z_m, point.row});
    options.noise_K = std::max(options.noise_K, plan.sensors[k].noise_K);
    options.offset_deviation_K = std::max(options.offset_deviation_K, plan.sensors[k].offset_deviation_K);
  }
  const correction::Identification found = correction::identify(
      network, sensors, rom::constant_schedule(network.boundaries, rom::seconds_per_hour), options);
  std::vector<correction::Parameter> parameters;
  std::vector<correction::ParameterEstimate> estimates;
  for (const correction::IdentifiedParameter& parameter : found.parameters) {
    parameters.push_back({parameter.name});
    estimates.push_back(parameter.estimate);
  }
  return fmt::format(
      "expected after an hour at {:.0f} rpm from a cold start: {} {:.1f} um, standard deviation {:.1f} um without "
      "sensors, {:.1f} um with {}; {}\n",
      network.boundaries.operating.speed_rpm, network.deformations.front().name, um_per_m * found.growth_m,
      um_per_m * found.prior_m, um_per_m * found.posterior_m, sensors.size(),
      what_is_determined(parameters, estimates));
}

}  // namespace spindle_twin::firmware
