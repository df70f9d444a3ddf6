#pragma once

#include <sundials/sundials_linearsolver.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <memory>

struct _generic_SUNMatrix;

namespace spindle_twin::rom {

/// Solutions with Newton's matrix for many step lengths and one network:
///   M = I + γ (K̃ − P X̃ Pᵀ),   K̃ = Q T Qᵀ with T tridiagonal
///   M⁻¹ b = Q (z + W c),   z = S⁻¹ Qᵀ b,   S = I + γT,   W = S⁻¹ QᵀP,   (I − γ X̃ PᵀQ W) c = γ X̃ PᵀQ z     (Woodbury)
/// With factors c on the capacities, D = diag(c), S = D^(−1/2), the same of what is symmetric again:
///   I + γ D⁻¹ (K̃ − P X̃ Pᵀ) = S (I + γ (S K̃ S − S P X̃ Pᵀ S)) S⁻¹
/// Q and T cost O(N³) once per K̃; another γ costs O(N) and, with M segments of coolant circuits, O(N M²). Not
/// thread-safe.
class NewtonSolver {
 public:
  /// Sizes all memory: nothing below calls the heap up to about 400 nodes and a few dozen segments, where Eigen's
  /// panels still fit its stack buffer. Throws std::runtime_error if out of memory. `context` must outlive it.
  NewtonSolver(Eigen::Index nodes, Eigen::Index segments, SUNContext context);

  /// K̃, of which the lower triangle is read, P, and 1 / c of the nodes' capacity factors (> 0; empty: all 1). All may
  /// change afterwards.
  void set_matrix(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& walls,
                  const Eigen::VectorXd& inverse_capacity = {});
  /// γ > 0 and X̃ (M x M). False if M is singular to working precision or not finite; solve() must then not be called.
  bool set_step(double gamma, const Eigen::MatrixXd& coupling);
  /// x = M⁻¹ b, N numbers each; they may be the same.
  void solve(const double* b, double* x);

  /// How often set_matrix() was called.
  long decompositions() const { return decompositions_; }

 private:
  struct Release {
    void operator()(_generic_SUNMatrix* matrix) const;
  };

  bool scaled_ = false;
  Eigen::VectorXd scale_;     // the diagonal of S
  Eigen::VectorXd scratch_;   // N
  Eigen::MatrixXd rotation_;  // Q
  Eigen::VectorXd reflectors_, workspace_;
  Eigen::VectorXd diagonal_, below_;  // of T
  std::unique_ptr<_generic_SUNMatrix, Release> band_;
  Eigen::Matrix<sunindextype, Eigen::Dynamic, 1> pivots_;
  Eigen::VectorXd rotated_;  // z
  double gamma_ = 0.0;
  Eigen::MatrixXd walls_;                     // QᵀP
  Eigen::MatrixXd responses_;                 // W
  Eigen::MatrixXd coupling_;                  // γ X̃
  Eigen::MatrixXd met_, small_;               // PᵀQ W; I − γ X̃ PᵀQ W
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;   // of small_
  Eigen::VectorXd at_walls_, fed_, circuit_;  // PᵀQ z; γ X̃ PᵀQ z; c
  long decompositions_ = 0;
};

/// `solver` as SUNDIALS sees it: its matrices come through CVodeSetLinSysFn, its setup does nothing. `solver` must
/// outlive it. Free with SUNLinSolFree. Null if out of memory.
SUNLinearSolver view_for_sundials(NewtonSolver& solver, SUNContext context);

}  // namespace spindle_twin::rom
