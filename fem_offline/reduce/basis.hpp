#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/loads.hpp"
#include "fem_offline/reduce/reduce.hpp"

namespace spindle_twin::fem_offline {

/// Columns with VᵀV = 1 over the unknowns (every unknown counts alike: errors are judged as temperatures, a thin part
/// as much as a thick one); column 0 is the constant vector, all others sum to zero.
struct RichBasis {
  Eigen::MatrixXd columns;  ///< unknowns x states
  int snapshots = 0;
  /// The first `bodies` columns span the functions that are 1 on one part or air volume and 0 elsewhere.
  int bodies = 1;
};

/// FE solutions (K + sC)⁻¹ [heats, environments, output rows] at random parameter sets, two in five at corners of the
/// box; of all snapshots those are kept whose distance to the span of the kept ones is largest (pivoted Cholesky of the
/// Gram matrix). Scales loads.outputs in place to the dual weights
/// times the primal snapshots.
RichBasis full_snapshot_basis(const AffineModel& model, Loads& loads, const ReduceOptions& options,
                              const Progress& progress);

/// The FE model tested with the rich basis V.
struct RichModel {
  DenseModel dense;
  Eigen::MatrixXd outputs;  ///< VᵀLᵀ, scaled
  int bodies = 1;           ///< as in RichBasis
};

RichModel project_model(const AffineModel& model, const Loads& loads, const Eigen::MatrixXd& basis, int threads);

/// Coordinates, in the rich basis, of the network's nested orthonormal basis: the bodies' columns and all left singular
/// vectors, largest first, of what the rich model does behind jumps of its operating state and of dual snapshots, at
/// new parameter sets.
Eigen::MatrixXd rich_snapshot_basis(const RichModel& rich, const rom::Boundaries& boundaries,
                                    const ReduceOptions& options, const Progress& progress);

}  // namespace spindle_twin::fem_offline
