#pragma once

#include <Eigen/Core>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/random_history.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// A model's thermal matrices and the analysis that all their factors share; for one thread.
struct AnalysedSystem {
  explicit AnalysedSystem(const AffineModel& model)
      : system(model), analysed(system.capacity_lower(), Solutions::of_many_factors) {}
  ThermalSystem system;
  CholeskyFactor analysed;
};

/// FE fields of a history, a column each, as rises above the reference temperature [K]. A wall that warmed up without
/// coolant and then meets it is cooled as no steady load cools it.
/// `matrices` are the model's; their conductances change.
Eigen::MatrixXd full_history(const AffineModel& model, AnalysedSystem& matrices, const History& history);

}  // namespace spindle_twin::fem_offline
