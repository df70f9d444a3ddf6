#pragma once

#include <Eigen/Core>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/random_history.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// FE fields of a history, a column each, as rises above the reference temperature [K]. A wall that warmed up without
/// coolant and then meets it is cooled as no steady load cools it.
/// `system` and `analysed` are the caller's own, for one thread; the system's conductances change.
Eigen::MatrixXd full_history(const AffineModel& model, ThermalSystem& system, const CholeskyFactor& analysed,
                             const History& history);

}  // namespace spindle_twin::fem_offline
