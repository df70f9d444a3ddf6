#pragma once

#include <Eigen/Core>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/thermal_test.hpp"

namespace spindle_twin::correction {

/// What readings and model may differ by although θ is right, r x r:
///   W = Σ_j σ_j² s_j s_jᵀ ∘ e^(−|Δt|/memory)    contacts wander by joint_wander, environments by their prior
///     + noise²/n + error² + (share rise)²         on the diagonal, of sensors
///     + probe noise²/n,  drift² e^(−|Δt|/memory)  of a probe
///     + Σ_k (0.3 start_k)² s_k s_kᵀ ∘ e^(−(t + t')/20 min)   what the shapes of a warm start may miss, as the
///     estimator
/// s_j: the readings' sensitivity to parameter j over the whole test, which stands for what a slow change would do.
/// start_k: start_deviation_K of a test that begins with spread_K (start_spread_K); none of one that begins cold,
/// spread_K 0.
Eigen::MatrixXd residual_covariance(const TestPrediction& prediction, const ParameterModel& parameters,
                                    const CalibrateOptions& options, double spread_K = 0.0);

}  // namespace spindle_twin::correction
