#pragma once

#include <Eigen/Core>

#include "fem_offline/sparse/sparse_matrix.hpp"

namespace spindle_twin::fem_offline {

/// A X of a symmetric A, of which `lower` holds the lower triangle. The same bits in any thread. Throws
/// std::runtime_error where there is no memory.
Eigen::MatrixXd symmetric_product(const SparseMatrix& lower, const Eigen::MatrixXd& columns);

}  // namespace spindle_twin::fem_offline
