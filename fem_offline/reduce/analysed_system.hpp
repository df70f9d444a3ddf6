#pragma once

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// A model's thermal matrices and the analysis that all their factors share; for one thread. Copies, for others, share
/// the analysis.
struct AnalysedSystem {
  explicit AnalysedSystem(const AffineModel& model)
      : system(model), analysed(system.capacity_lower(), Solutions::of_many_factors) {}
  ThermalSystem system;
  CholeskyAnalysis analysed;
};

}  // namespace spindle_twin::fem_offline
