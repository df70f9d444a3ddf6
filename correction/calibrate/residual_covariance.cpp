#include "correction/calibrate/residual_covariance.hpp"

#include <cmath>

#include "correction/calibrate/unknowns.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double missed_memory_s = 1200.0;  // of what a start's shapes miss; of its variance half as long

double squared(double value) { return value * value; }

/// Of one reading by itself.
double own_variance(const TestReading& reading, const CalibrateOptions& options) {
  if (reading.channel >= static_cast<int>(options.sensors.size())) {
    return squared(options.probe_noise_m) / reading.samples;
  }
  const EstimatorSensor& sensor = options.sensors[static_cast<std::size_t>(reading.channel)];
  return squared(sensor.noise_K) / reading.samples + squared(options.sensor_error_K) +
         squared(options.sensor_error_share * reading.rise);
}

/// e^(−|Δt|/memory) of each pair of readings.
Eigen::MatrixXd correlation(const std::vector<TestReading>& readings, double memory_s) {
  const auto count = static_cast<Eigen::Index>(readings.size());
  Eigen::MatrixXd of(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const double apart_s =
          readings[static_cast<std::size_t>(i)].time_s - readings[static_cast<std::size_t>(k)].time_s;
      of(i, k) = std::exp(-std::abs(apart_s) / memory_s);
    }
  }
  return of;
}

/// What no shape of the start has of it: a share of each, which fades as neighbours meet.
Eigen::MatrixXd of_missed_start(const TestPrediction& prediction, const ParameterModel& parameters, double spread_K) {
  const auto count = static_cast<Eigen::Index>(prediction.readings.size());
  const double begin_s = prediction.readings.empty() ? 0.0 : prediction.readings.front().time_s;
  Eigen::VectorXd left(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    left[r] = std::exp(-(prediction.readings[static_cast<std::size_t>(r)].time_s - begin_s) / missed_memory_s);
  }
  Eigen::MatrixXd missed = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    if (!parameters.is_start(i)) continue;
    const Eigen::VectorXd column = start_missed_share * start_deviation_K(parameters, i, spread_K) *
                                   prediction.sensitivities.col(i).cwiseProduct(left);
    missed.noalias() += column * column.transpose();
  }
  return missed;
}

}  // namespace

Eigen::MatrixXd residual_covariance(const TestPrediction& prediction, const ParameterModel& parameters,
                                    const CalibrateOptions& options, double spread_K) {
  const auto count = static_cast<Eigen::Index>(prediction.readings.size());
  Eigen::MatrixXd joints = Eigen::MatrixXd::Zero(count, count), inlets = joints, drift = joints;
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const auto column = prediction.sensitivities.col(i);
    if (parameter.kind == ParameterKind::contact) {
      joints.noalias() += squared(options.joint_wander) * column * column.transpose();
    } else if (parameter.kind == ParameterKind::environment) {
      inlets.noalias() += squared(parameter.deviation) * column * column.transpose();
    }
  }
  const int sensors = static_cast<int>(options.sensors.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const int channel = prediction.readings[static_cast<std::size_t>(i)].channel;
    if (channel < sensors) continue;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (prediction.readings[static_cast<std::size_t>(k)].channel == channel) {
        drift(i, k) = squared(options.probe_drift_m);
      }
    }
  }
  Eigen::MatrixXd covariance =
      (joints + drift).cwiseProduct(correlation(prediction.readings, options.memory_s)) +
      inlets.cwiseProduct(correlation(prediction.readings, options.priors.environment_memory_s));
  if (spread_K > 0.0) covariance += of_missed_start(prediction, parameters, spread_K);
  for (Eigen::Index i = 0; i < count; ++i) {
    covariance(i, i) += own_variance(prediction.readings[static_cast<std::size_t>(i)], options);
  }
  return covariance;
}

}  // namespace spindle_twin::correction
