#pragma once

#include <cholmod.h>

#include <Eigen/Core>
#include <cstddef>

#include "fem_offline/sparse/sparse_matrix.hpp"

namespace spindle_twin::fem_offline {

/// CHOLMOD's view of an Eigen matrix; it only reads.
inline cholmod_sparse view_of(const SparseMatrix& lower) {
  cholmod_sparse sparse{};
  sparse.nrow = static_cast<std::size_t>(lower.rows());
  sparse.ncol = static_cast<std::size_t>(lower.cols());
  sparse.nzmax = static_cast<std::size_t>(lower.nonZeros());
  sparse.p = const_cast<int*>(lower.outerIndexPtr());
  sparse.i = const_cast<int*>(lower.innerIndexPtr());
  sparse.x = const_cast<double*>(lower.valuePtr());
  sparse.stype = -1;
  sparse.itype = CHOLMOD_INT;
  sparse.xtype = CHOLMOD_REAL;
  sparse.dtype = CHOLMOD_DOUBLE;
  sparse.sorted = 1;
  sparse.packed = 1;
  return sparse;
}

/// CHOLMOD's view of columns; what it does to them is its caller's choice.
inline cholmod_dense view_of(const double* columns, Eigen::Index rows, Eigen::Index count) {
  cholmod_dense dense{};
  dense.nrow = dense.d = static_cast<std::size_t>(rows);
  dense.ncol = static_cast<std::size_t>(count);
  dense.nzmax = dense.nrow * dense.ncol;
  dense.x = const_cast<double*>(columns);
  dense.xtype = CHOLMOD_REAL;
  dense.dtype = CHOLMOD_DOUBLE;
  return dense;
}

}  // namespace spindle_twin::fem_offline
