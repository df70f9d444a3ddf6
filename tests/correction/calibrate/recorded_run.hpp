#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "correction/calibrate/predict_test.hpp"
#include "correction/estimator/estimator_correction.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {

/// What a machine with hidden parameters records in a test of plates(), in steps shorter than the predictor's.
struct RecordedRun {
  double length_s = 3600.0;
  double sensor_noise_K = 0.02;
  double probe_noise_m = 1e-6;
  double zero_m = 30e-6;
  double start_K = 0.0;  ///< above the reference temperature
  std::uint64_t seed = 1;
};

/// Truth from the priors of `parameters`, reproducible.
inline Eigen::VectorXd drawn(const ParameterModel& parameters, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Eigen::VectorXd theta = parameters.mean();
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const double step = normal(random);
    if (parameter.kind == ParameterKind::environment || parameter.kind == ParameterKind::start) continue;
    theta[i] = std::clamp(theta[i] + parameter.deviation * step, parameter.minimum, parameter.maximum);
  }
  return theta;
}

inline ThermalTest record(const rom::Network& network, const ParameterModel& parameters, const Eigen::VectorXd& theta,
                          const RecordedRun& run) {
  constexpr double step_s = 2.0;
  std::mt19937_64 random(run.seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Model plant(network);
  const double reference_K = network.boundaries.reference_temperature_K;
  plant.stepper.set_temperatures(Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), reference_K + run.start_K));
  rom::evaluate_outputs(network, plant.stepper.temperatures_K(), plant.outputs);
  rom::CorrectionFactors factors = parameters.make_factors(network);
  rom::OperatingState operating = network.boundaries.operating;
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(operating.environment_K.size());
  Eigen::VectorXd rises_K = Eigen::VectorXd::Zero(factors.heat.size());
  const auto sensors = static_cast<Eigen::Index>(network.key_points.size());
  const auto outputs = static_cast<Eigen::Index>(network.deformations.size());
  const auto instants = static_cast<Eigen::Index>(std::lround(run.length_s / 10.0)) + 1;
  ThermalTest test;
  test.name = "recorded";
  test.start_K = reference_K + run.start_K;
  test.measured_K.resize(instants, sensors);
  test.deformation_m = Eigen::MatrixXd::Constant(instants, outputs, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 0; k < instants; ++k) {
    const double time_s = 10.0 * static_cast<double>(k);
    const double phase = time_s / run.length_s;
    operating.speed_rpm = phase < 0.4 ? 9000.0 : phase < 0.7 ? 3000.0 : 6000.0;
    test.time_s.push_back(time_s);
    test.operating.push_back(operating);
    for (Eigen::Index s = 0; s < sensors; ++s) {
      test.measured_K(k, s) = plant.outputs.key_points_K[s] + run.sensor_noise_K * normal(random);
    }
    test.deformation_m(k, 0) = plant.outputs.deformations_m[0] + run.zero_m + run.probe_noise_m * normal(random);
    for (int part = 0; part < 5; ++part) {
      for (Eigen::Index i = 0; i < rises_K.size(); ++i) {
        rises_K[i] = network.source_distribution.col(i).dot(plant.stepper.temperatures_K()) - reference_K;
      }
      parameters.apply(theta, operating.speed_rpm, rises_K, factors, bias_K);
      plant.advance(step_s, operating, factors);
    }
  }
  return test;
}

/// Of a machine that was never tested, with what plates() has.
inline CalibrateOptions calibrate_options(const rom::Network& network) {
  CalibrateOptions options;
  options.priors.disturbance = 0.0;
  options.sensors = key_point_sensors(network, {});
  options.lag_deviation_s = 1e-3;  // these sensors have none
  options.starts = 1;              // for most tests; others see several_starts_test.cpp
  return options;
}

}  // namespace spindle_twin::correction::test
