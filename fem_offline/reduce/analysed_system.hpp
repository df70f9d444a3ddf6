#pragma once

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/solve/held_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// A model under held inputs and the analysis that all factors of its matrices share; for one thread. Copies, for
/// others, share the analysis.
struct AnalysedSystem {
  explicit AnalysedSystem(const AffineModel& model)
      : system(model), analysed(system.matrices().capacity_lower(), Solutions::of_many_factors) {}
  HeldSystem system;
  CholeskyAnalysis analysed;
};

}  // namespace spindle_twin::fem_offline
