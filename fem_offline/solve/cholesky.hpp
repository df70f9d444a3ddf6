#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// Factors of one sparse symmetric positive definite matrix, A = L Lᵀ (CHOLMOD; supernodal for large
/// ones if the BLAS may be called by several threads). The symbolic analysis can
/// be handed on to other matrices of the same pattern.
class CholeskyFactor {
 public:
  /// Analyses and factorises. `lower` holds the lower triangle. Throws std::runtime_error if A is not positive
  /// definite.
  explicit CholeskyFactor(const SparseMatrix& lower);
  /// Takes the analysis of `pattern`, whose matrix had the same entries.
  CholeskyFactor(const CholeskyFactor& pattern, const SparseMatrix& lower);
  ~CholeskyFactor();
  CholeskyFactor(CholeskyFactor&&) noexcept;
  CholeskyFactor& operator=(CholeskyFactor&&) noexcept;

  /// A x = b. Not for two threads on one factor at once: it keeps its workspace.
  void solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
