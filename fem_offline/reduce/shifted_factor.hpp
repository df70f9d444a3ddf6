#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// The terms of an AffineModel laid over one common lower-triangular pattern, so that K₀ + Σ gⱼKⱼ + sC is a sum of
/// value arrays. Read-only, shared by all workers.
class AffinePattern {
 public:
  explicit AffinePattern(const AffineModel& model);
  /// Writes the values of K₀ + Σ gⱼKⱼ + shift·C in the order of lower().
  void assemble(const Eigen::VectorXd& conductance_W_per_m2K, double shift_per_s, Eigen::VectorXd& values) const;
  const SparseMatrix& lower() const { return lower_; }

 private:
  struct Entry {
    int position;
    double value;
  };
  std::vector<Entry> positions(const SparseMatrix& term) const;
  SparseMatrix lower_;
  std::vector<Entry> capacity_;
  std::vector<Entry> conduction_;
  std::vector<std::vector<Entry>> conductance_terms_;
};

/// CHOLMOD factor of K₀ + Σ gⱼKⱼ + sC; the symbolic analysis is done once. One per worker.
class ShiftedFactor {
 public:
  explicit ShiftedFactor(const AffinePattern& pattern);
  ~ShiftedFactor();
  ShiftedFactor(const ShiftedFactor&) = delete;
  ShiftedFactor& operator=(const ShiftedFactor&) = delete;

  /// Throws std::runtime_error when the matrix is not positive definite.
  void factorise(const Eigen::VectorXd& conductance_W_per_m2K, double shift_per_s);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
