#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "correction/calibrate/thermal_test.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::correction {

/// One averaged reading beside what the model says of it.
struct TestReading {
  double time_s = 0.0;
  int channel = 0;        ///< sensors first, then deformation outputs
  double residual = 0.0;  ///< reading − model, without the channel's offset or zero; K or m
  double rise = 0.0;      ///< of the reading above the test's start temperature, K; 0 of a deformation
  int samples = 1;
  double lag_slope = 0.0;  ///< d(model)/dτ of the sensor, K/s
  double value = 0.0;      ///< mean of the readings; K or m
};

/// A whole test with one θ: r readings, p parameters.
struct TestPrediction {
  std::vector<TestReading> readings;
  Eigen::MatrixXd sensitivities;  ///< r x p, d(model)/dθ
  Eigen::VectorXd last_output;    ///< p, d(first deformation output)/dθ at the end; empty without one
};

/// Runs the model along tests. Not for the cycle.
class TestPredictor {
 public:
  /// `network` and `options` must outlive this.
  TestPredictor(const rom::Network& network, const CalibrateOptions& options);

  const ParameterModel& parameters() const { return parameters_; }

  /// The model from start_K and θ's start shapes on, with factors and biases of θ, in the steps of test_steps, and the
  /// exact derivatives of what comes out (SteppedState): places of sensors and outputs run straight from step to step,
  /// and sensors follow their places with lag_s, one per sensor, >= 0. A channel's readings of one period of held_s,
  /// or until inputs change, become one TestReading, at most one each interval_s. The same bits from any thread. Throws
  /// rom::InputError naming the test where the model cannot be integrated.
  TestPrediction predict(const ThermalTest& test, const Eigen::VectorXd& theta, const Eigen::VectorXd& lag_s) const;

 private:
  const rom::Network* network_;
  const CalibrateOptions* options_;
  std::shared_ptr<const rom::NetworkOperator> coordinates_;
  ParameterModel parameters_;
};

}  // namespace spindle_twin::correction
