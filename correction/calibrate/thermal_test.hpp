#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "correction/estimator/measurement.hpp"
#include "correction/estimator/parameters.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// One recorded run of a machine, at instants that rise strictly; NaN: no new reading.
struct ThermalTest {
  std::string name;  ///< for messages and the calibration's file
  std::vector<double> time_s;
  std::vector<rom::OperatingState> operating;  ///< as read, from each instant to the next
  Eigen::MatrixXd measured_K;                  ///< instants x sensors of CalibrateOptions
  Eigen::MatrixXd deformation_m;               ///< instants x deformation outputs; zero of each unknown
  double start_K = 0.0;                        ///< the whole spindle at the first instant, as far as known

  double length_s() const { return time_s.back() - time_s.front(); }
};

/// Priors of a test from those of service: laws of speed and of temperature are open, which hours of several speeds
/// tell; no heat stays unexplained, which would take what the parameters are wrong by; and nothing is calibrated yet.
inline EstimatorPriors test_priors(EstimatorPriors priors) {
  constexpr double open_speed_exponent = 0.2;  // 1σ
  constexpr double open_bearing_per_K = 0.01;  // 1σ
  priors.disturbance = priors.disturbance_by_hand = 0.0;
  priors.speed_exponent = std::max(priors.speed_exponent, open_speed_exponent);
  priors.bearing_per_K = std::max(priors.bearing_per_K, open_bearing_per_K);
  priors.calibrated = nullptr;
  return priors;
}

/// What is assumed of readings, model and machine. Deviations are 1σ.
struct CalibrateOptions {                // NOLINT(public-members): a table of options
  EstimatorPriors priors;                ///< of an unknown machine
  std::vector<EstimatorSensor> sensors;  ///< permanent and temporary ones
  double lag_deviation_s = 14.0;
  double interval_s = 60.0;          ///< between the readings of a channel that count
  double held_s = 60.0;              ///< over which readings are averaged
  double longest_step_s = 20.0;      ///< of the model (test_steps)
  double probe_noise_m = 1e-6;       ///< of one reading
  double probe_drift_m = 0.5e-6;     ///< slow, over memory_s
  double sensor_error_K = 0.05;      ///< of the model at a sensor
  double sensor_error_share = 0.01;  ///< of the rise besides
  double joint_wander = 0.12;        ///< ln of each contact about its mean, over memory_s
  double memory_s = 3600.0;
  int starts = 5;                ///< from which the fit begins (fit_from_several), 1 to 50
  std::uint64_t start_seed = 1;  ///< of their draws
};

}  // namespace spindle_twin::correction
