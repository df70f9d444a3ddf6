#pragma once

#include <Eigen/Core>
#include <memory>

#include "rom/boundaries.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom {

/// f(x) = −K̃ x + u with the inputs of one cycle held; its Jacobian is −K̃. With coolant circuits f(x) = −K̃x + u + PX̃Pᵀx
/// (NetworkOperator). One per stepper, over a shared operator.
class RightHandSide {
 public:
  explicit RightHandSide(std::shared_ptr<const NetworkOperator> network);

  const NetworkOperator& network() const { return *network_; }

  /// Takes over the inputs of the next period; assembles K̃ only if a conductance differs from the last ones.
  /// Returns whether the Jacobian changed. Cycle-safe.
  bool hold(const BoundaryValues& values);

  /// Those in K̃.
  const Eigen::VectorXd& conductance_W_per_m2K() const { return assembled_for_W_per_m2K_; }

  /// dx = f(x). Cycle-safe; x and dx hold N numbers each and do not overlap.
  void evaluate(const double* x, double* dx) const;

  /// Whether a circuit makes the Jacobian −K̃ + PX̃Pᵀ, which is not symmetric.
  bool coupled() const { return coupling_.size() > 0; }
  /// target = K̃ − PX̃Pᵀ in full. Cycle-safe for `target` of N x N.
  void full(Eigen::Ref<Eigen::MatrixXd> target) const;

  /// X̃, empty without circuits.
  const Eigen::MatrixXd& coupling() const { return coupling_; }
  /// K̃, lower triangle valid.
  const Eigen::MatrixXd& lower() const { return lower_; }
  const Eigen::VectorXd& drive() const { return drive_; }

 private:
  void assemble(const Eigen::VectorXd& conductance_W_per_m2K);

  std::shared_ptr<const NetworkOperator> network_;
  Eigen::VectorXd assembled_for_W_per_m2K_;
  bool assembled_ = false;
  // Mostly films move and contacts do not, so K̃ is made from an earlier one and the terms that differ from it.
  Eigen::VectorXd base_W_per_m2K_;
  Eigen::VectorXd base_packed_, packed_;
  Eigen::MatrixXd lower_;
  Eigen::VectorXd drive_;
  Eigen::VectorXd held_coolant_W_per_K_;
  Eigen::MatrixXd coupling_;                   // X̃
  mutable Eigen::VectorXd walls_;              // Pᵀ x; scratch
  mutable Eigen::VectorXd fed_;                // X̃ Pᵀ x; scratch
  mutable Eigen::MatrixXd walls_by_coupling_;  // P X̃; scratch
};

/// Whether every input is a finite number. Cycle-safe.
bool all_finite(const BoundaryValues& values);

}  // namespace spindle_twin::rom
