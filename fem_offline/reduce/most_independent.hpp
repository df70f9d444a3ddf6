#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/reduce/column_store.hpp"

namespace spindle_twin::fem_offline {

/// Indices of at most `most` columns, each the farthest from the span of those before it, until what is left of every
/// column is below 3e-8 of the longest: Cholesky with complete pivoting of their Gram matrix, of which only those
/// columns are made that come near to being chosen. Products are in double and the same for any number of threads.
/// Throws std::runtime_error where all columns are zero.
std::vector<int> most_independent(const ColumnStore<float>& columns, Eigen::Index most, int threads);

/// The same of the rows of a matrix.
std::vector<int> most_independent_rows(const Eigen::MatrixXd& matrix, Eigen::Index most, int threads);

}  // namespace spindle_twin::fem_offline
