#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <memory>

#include "rom/integrate/right_hand_side.hpp"
#include "rom/integrate/stepper.hpp"

namespace spindle_twin::rom {

/// The exact solution for held inputs. With K̃ = V Λ Vᵀ and period h:
///   x(t+h) = V ( e^(−Λh) Vᵀ x(t) + φ(Λh) h Vᵀ u ),   φ(z) = (1 − e^(−z)) / z, φ(0) = 1
/// With coolant circuits the matrix A = K̃ − PX̃Pᵀ has no orthogonal eigenvectors, and segments in a row bring it near to
/// having too few; there, by the exponential of a matrix of order 2N,
///   [E Φ; 0 1] = exp([−A 1; 0 0] h),   x(t+h) = E x(t) + Φ u
/// Factors on the capacities, S = diag(c)^(−1/2): the same of S K̃ S, S⁻¹ x and S u; with circuits of S² A and S² u.
/// Physical laws are held at what they are at the start of the period, so with them it is of first order in h only.
/// No step-size error for any h: oracle of the tests and fallback of the daemon. An eigendecomposition (about 9 N³
/// multiply-adds, may allocate) whenever a conductance changes, the exponential also when flow or period do; otherwise
/// two products with V, or E and Φ, per period.
class ExactStepper final : public Stepper {
 public:
  /// Starts at the network's reference temperature. Allocates.
  explicit ExactStepper(std::shared_ptr<const NetworkOperator> network);

  void set_temperatures(const Eigen::VectorXd& temperatures_K) override;

  /// period_s > 0 and finite, else integrator_failed. Values sized as the network's boundaries.
  StepStatus advance(double period_s, const BoundaryValues& values) override;
  const Eigen::VectorXd& temperatures_K() const override { return temperatures_K_; }

 private:
  bool advance_symmetric(double period_s, const BoundaryValues& values);
  bool advance_coupled(double period_s, const BoundaryValues& values);

  RightHandSide rhs_;
  BoundaryValues held_;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes_;
  bool decomposed_ = false;
  double exponential_for_s_ = 0.0;
  Eigen::MatrixXd exponential_, integral_;  // E, Φ
  Eigen::VectorXd x_;
  Eigen::VectorXd x_new_;
  Eigen::VectorXd modal_;
  Eigen::VectorXd modal_drive_;
  Eigen::VectorXd temperatures_K_;
  Eigen::VectorXd candidate_K_;
};

}  // namespace spindle_twin::rom
