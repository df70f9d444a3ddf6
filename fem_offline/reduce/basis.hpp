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
  /// Rows of V at as many unknowns as it has columns, chosen by pivoting: where they are near, fields are.
  Eigen::MatrixXd points;
  std::vector<int> part_of_point;  ///< the parts' number for air
};

/// VᵀKV of a symmetric K that may touch few unknowns; symmetric to the bit.
Eigen::MatrixXd project_term(const SparseMatrix& term, const Eigen::MatrixXd& basis);
/// F with FFᵀ = VᵀKV, of the smallest rank that rounding allows; K without negative eigenvalues.
Eigen::MatrixXd project_term_factor(const SparseMatrix& term, const Eigen::MatrixXd& basis);

/// The FE model tested with the columns of a basis.
DenseModel project_dense(const AffineModel& model, const Eigen::MatrixXd& basis, int threads);

RichModel project_model(const AffineModel& model, const Loads& loads, const Eigen::MatrixXd& basis, int threads);

/// In the rich basis.
struct RichSnapshots {
  Eigen::MatrixXd fields;        ///< rises along histories with jumps of the operating state, a column each
  Eigen::MatrixXd dual_moments;  ///< XXᵀ of the solutions X for the output rows, which would be the larger matrix
};

/// Of the rich model at options.rich_sets random parameter sets.
RichSnapshots rich_snapshots(const RichModel& rich, const rom::Boundaries& boundaries, const ReduceOptions& options,
                             const Progress& progress);

/// Coordinates, in the rich basis, of the network's nested basis, orthonormal: the bodies' columns and all left
/// singular vectors of the snapshots, largest first, in an inner product over rich.points that weighs parts so that all
/// keep about the same largest error.
Eigen::MatrixXd network_basis(const RichModel& rich, const RichSnapshots& snapshots, int threads);

}  // namespace spindle_twin::fem_offline
