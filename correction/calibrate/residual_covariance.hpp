#pragma once

#include <Eigen/Core>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/thermal_test.hpp"

namespace spindle_twin::correction {

/// What readings and model may differ by although θ is right, r x r:
///   W = Σ_j σ_j² s_j s_jᵀ ∘ e^(−|Δt|/memory)    contacts wander by joint_wander, environments by their prior
///     + noise²/n + error² + (share rise)²         on the diagonal, of sensors
///     + probe noise²/n,  drift² e^(−|Δt|/memory)  of a probe
/// s_j: the readings' sensitivity to parameter j over the whole test, which stands for what a slow change would do.
Eigen::MatrixXd residual_covariance(const TestPrediction& prediction, const ParameterModel& parameters,
                                    const CalibrateOptions& options);

}  // namespace spindle_twin::correction
