#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "fem_offline/sparse/sparse_matrix.hpp"

namespace spindle_twin::fem_offline {

/// Whether the program's BLAS is OpenBLAS and several threads may call it at once.
bool openblas_serves_threads();

/// What a factor is wanted for.
enum class Solutions {
  of_many_factors,  ///< the ordering is by nested dissection: it takes ten times as long, each factor a tenth to a
                    ///< quarter less
  many,             ///< a large one is stored again by columns, which takes a third less time per solution
  few               ///< it stays as it is made, which takes half the memory meanwhile
};

/// Ordering and pattern of a factor, without values: for many matrices with the same entries. Copies share it, also
/// between threads.
class CholeskyAnalysis {
 public:
  /// `lower` holds the lower triangle; its values do not count.
  explicit CholeskyAnalysis(const SparseMatrix& lower, Solutions wanted = Solutions::many);

 private:
  friend class CholeskyFactor;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Factors of one sparse symmetric positive definite matrix, A = L D Lᵀ (CHOLMOD; large ones are made block by block on
/// the BLAS if several threads may call it at once). The calling program's OpenBLAS is held to one thread from its
/// start.
class CholeskyFactor {
 public:
  /// Analyses and factorises. `lower` holds the lower triangle. Throws std::runtime_error if A is not positive
  /// definite, the second constructor too.
  explicit CholeskyFactor(const SparseMatrix& lower, Solutions wanted = Solutions::many);
  /// With an analysis of a matrix that had the same entries.
  CholeskyFactor(const CholeskyAnalysis& analysis, const SparseMatrix& lower);
  ~CholeskyFactor();
  CholeskyFactor(CholeskyFactor&&) noexcept;
  CholeskyFactor& operator=(CholeskyFactor&&) noexcept;

  /// Its own, or the one it was given.
  const CholeskyAnalysis& analysis() const;

  /// A x = b. Not for two threads on one factor at once: it keeps its workspace.
  void solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution);
  /// A X = B, all columns in one pass over the factor; the same warning.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides);

 private:
  void solve(const double* loads, Eigen::Index columns, double* solutions);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
