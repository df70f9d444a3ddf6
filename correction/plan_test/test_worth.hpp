#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/thermal_test.hpp"
#include "correction/calibration/calibration.hpp"
#include "rom/boundary_values/schedule.hpp"

namespace spindle_twin::correction {

/// What a test is to be made for.
struct WorthOptions {
  CalibrateOptions calibrate;  ///< as calibrate is going to be run; sensors: those that stay first, then candidates
  std::size_t permanent = 0;   ///< of the sensors: how many there are in service
  DriftOptions drift;          ///< between test and service
  std::size_t probe = 0;       ///< deformation output that the probe measures, and that service is judged by
  double judged_from_s = 900.0;
};

/// Which readings of a test are taken.
struct TakenReadings {
  std::vector<std::size_t> sensors;  ///< indices into WorthOptions::calibrate.sensors, rising
  bool probe = true;
  double until_s = std::numeric_limits<double>::infinity();
};

/// rms over service of 1σ of the deformation output, m.
struct Worth {
  double with_sensors_m = 0.0;  ///< by the filter with the permanent sensors
  double open_loop_m = 0.0;     ///< without a sensor in service
};

/// Linearised posterior of a test and what it leaves in service, at the means of the priors; no reading is needed:
///   P = (P₀⁻¹ + Hᵀ W⁻¹ H)⁻¹            H the readings' sensitivities, W residual_covariance, as calibrate has both
///   Q = P of the machine + drift², priors of the day for all else
///   σ(t)² = l(t)ᵀ (Q⁻¹ + Σ_{t' <= t} hᵀ W⁻¹ h)⁻¹ l(t),   over the readings of service up to t
/// Of one drift, a reading more and a longer test never make it larger. Not for the cycle.
class TestWorth {
 public:
  /// Integrates the service drive once. `network` must outlive this. Throws rom::InputError for a network without that
  /// output, and where the model cannot be integrated.
  TestWorth(const rom::Network& network, WorthOptions options, const rom::Schedule& service);

  /// Sensitivities of all sensors and of the probe along a drive, from rest. The same bits from any thread.
  TestPrediction linearise(const rom::Schedule& test) const;
  /// Without a reading that of the priors. A test that tells less than the drift since takes away leaves a little more.
  Worth of(const TestPrediction& test, const TakenReadings& taken) const;
  /// Of the priors alone.
  Worth untested() const;
  /// Of a machine that was known at the test: what drift and the day leave, which no test betters.
  Worth known() const;

 private:
  struct Service {
    Eigen::MatrixXd prior;               // of z
    Eigen::MatrixXd whitened;            // L⁻¹H, readings x z
    std::vector<Eigen::Index> readings;  // up to each judged instant
    Eigen::MatrixXd outputs;             // l, instants x z
    std::vector<std::string> names;      // of the machine's parameters
  };

  Worth in_service(const Eigen::MatrixXd& machine) const;

  const rom::Network* network_;
  WorthOptions options_;
  TestPredictor predictor_;
  Service service_;
};

}  // namespace spindle_twin::correction
