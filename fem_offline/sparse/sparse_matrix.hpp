#pragma once

#include <Eigen/SparseCore>

namespace spindle_twin::fem_offline {

using SparseMatrix = Eigen::SparseMatrix<double>;  // column-major, both triangles stored

/// What `given` holds, without a copy; it is empty afterwards. Eigen 3.4 copies a sparse matrix where it is moved.
inline SparseMatrix taken(SparseMatrix& given) {
  SparseMatrix matrix;
  matrix.swap(given);
  return matrix;
}

}  // namespace spindle_twin::fem_offline
