#pragma once

#include <cholmod.h>

#include <Eigen/Core>
#include <cstddef>

#include "fem_offline/sparse/cholmod_view.hpp"
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
    cholmod_sparse view = fem_offline::view_of(lower);
    factor_ = cholmod_analyze(&view, &common_);
  }
  /// Bytes of the factor, by CHOLMOD's own count; before the first solution.
  std::size_t factor_bytes() {
    cholmod_free_work(&common_);
    return common_.memory_inuse;
  }
  void factorise(const SparseMatrix& lower) {
    cholmod_sparse view = fem_offline::view_of(lower);
    cholmod_factorize(&view, factor_, &common_);
  }
  void solve(const Eigen::VectorXd& load) {
    cholmod_dense given = fem_offline::view_of(load.data(), load.size(), 1);
    cholmod_solve2(CHOLMOD_A, factor_, &given, nullptr, &solution_, nullptr, &workspace_y_, &workspace_e_, &common_);
  }

 private:
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* workspace_y_ = nullptr;
  cholmod_dense* workspace_e_ = nullptr;
};

}  // namespace spindle_twin::bench
