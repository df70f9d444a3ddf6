#pragma once

#include <cholmod.h>

#include <Eigen/Core>
#include <cstddef>

#include "fem_offline/sparse/sparse_matrix.hpp"

namespace spindle_twin::bench {

using fem_offline::SparseMatrix;

/// CHOLMOD as it comes: its own choice of ordering and method.
class BareCholmod {
 public:
  BareCholmod() { cholmod_start(&common_); }
  ~BareCholmod() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&workspace_y_, &common_);
    cholmod_free_dense(&workspace_e_, &common_);
    cholmod_finish(&common_);
  }
  BareCholmod(const BareCholmod&) = delete;
  BareCholmod& operator=(const BareCholmod&) = delete;

  void analyse(const SparseMatrix& lower) {
    cholmod_free_factor(&factor_, &common_);
    cholmod_sparse view = view_of(lower);
    factor_ = cholmod_analyze(&view, &common_);
  }
  /// Bytes of the factor, by CHOLMOD's own count; before the first solution.
  std::size_t factor_bytes() {
    cholmod_free_work(&common_);
    return common_.memory_inuse;
  }
  void factorise(const SparseMatrix& lower) {
    cholmod_sparse view = view_of(lower);
    cholmod_factorize(&view, factor_, &common_);
  }
  void solve(const Eigen::VectorXd& load) {
    cholmod_dense given{};
    given.nrow = given.nzmax = given.d = static_cast<std::size_t>(load.size());
    given.ncol = 1;
    given.x = const_cast<double*>(load.data());
    given.xtype = CHOLMOD_REAL;
    given.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_A, factor_, &given, nullptr, &solution_, nullptr, &workspace_y_, &workspace_e_, &common_);
  }

 private:
  static cholmod_sparse view_of(const SparseMatrix& lower) {
    cholmod_sparse view{};
    view.nrow = static_cast<std::size_t>(lower.rows());
    view.ncol = static_cast<std::size_t>(lower.cols());
    view.nzmax = static_cast<std::size_t>(lower.nonZeros());
    view.p = const_cast<int*>(lower.outerIndexPtr());
    view.i = const_cast<int*>(lower.innerIndexPtr());
    view.x = const_cast<double*>(lower.valuePtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
  }

  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* workspace_y_ = nullptr;
  cholmod_dense* workspace_e_ = nullptr;
};

}  // namespace spindle_twin::bench
