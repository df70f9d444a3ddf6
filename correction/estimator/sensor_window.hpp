#pragma once

#include <Eigen/Core>
#include <cmath>

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {

/// Response of τ y' = u − y after h seconds in which u runs linearly from u0 to u1; u1 itself without a lag.
inline double lag(double y, double u0, double u1, double h_s, double tau_s) {
  if (tau_s <= 0.0) return u1;
  if (h_s <= 0.0) return y;
  const double keep = std::exp(-h_s / tau_s);
  return keep * y + (1.0 - keep) * u0 + (u1 - u0) * (1.0 - (1.0 - keep) * tau_s / h_s);
}

/// What a channel gathers between two updates. Readings and predictions are taken alike, so that their mean difference
/// is an innovation whatever the temperature has done meanwhile.
struct SensorWindow {
  Eigen::VectorXd internal;                                             ///< row on x
  Eigen::VectorXd sensitivity, sensitivity_before, lagged_sensitivity;  ///< p, at the last closed period
  double temperature_K = 0.0;                                           ///< of the model at the sensor
  double lagged_K = 0.0;                                                ///< what the sensor would show of it
  double measured_K = 0.0;                                              ///< sums over the window
  double residual_K = 0.0;
  int samples = 0;
  double fused_s = -1e9;
  SensorRecord record;

  void clear() {
    measured_K = residual_K = 0.0;
    samples = 0;
  }

  void start(double model_K) {
    temperature_K = lagged_K = model_K;
    sensitivity.setZero();
    sensitivity_before.setZero();
    lagged_sensitivity.setZero();
    fused_s = -1e9;
    clear();
  }

  void predict(double model_K, double elapsed_s, double lag_s) {
    lagged_K = lag(lagged_K, temperature_K, model_K, elapsed_s, lag_s);
    temperature_K = model_K;
  }

  void observe(double reading_K) {
    if (!std::isfinite(reading_K)) return;
    measured_K += reading_K;
    residual_K += reading_K - lagged_K;
    ++samples;
  }

  void lag_sensitivity(double period_s, double lag_s) {
    for (Eigen::Index i = 0; i < sensitivity.size(); ++i) {
      lagged_sensitivity[i] = lag(lagged_sensitivity[i], sensitivity_before[i], sensitivity[i], period_s, lag_s);
    }
  }
};

}  // namespace spindle_twin::correction
