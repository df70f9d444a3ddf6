#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <memory>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/sensitivities.hpp"
#include "rom/integrate/right_hand_side.hpp"

namespace spindle_twin::correction {

/// The network's state x (rom::NetworkOperator) with fixed parameters θ, and S = dx/dθ as the exact derivative of the
/// steps that x takes. With f(x, θ) the right-hand side of rom::RightHandSide, laws, circuits and friction at the
/// temperatures x, one step of SDIRK2 (γ = 1 − 1/√2, L-stable, stiffly accurate, of order 2) with held inputs:
///   Y₁ = x + γh f(Y₁),   x' = Y₂ = x + (1 − γ)/γ (Y₁ − x) + γh f(Y₂)                                  (Newton)
///   (1 + γhA(Y)) S_Y = S_z + γh D(Y),   A = −∂f/∂x,  D = ∂f/∂θ (Sensitivities),   S_z as z of the stage   (LU)
/// Not for the cycle, nor for several threads.
class SteppedState {
 public:
  /// `network` and `parameters` must outlive this.
  SteppedState(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates,
               const ParameterModel& parameters, const Eigen::VectorXd& theta);

  /// From start_K, the same at all nodes, with the start shapes of θ; S is that of the start alone.
  void start(double start_K);
  /// `operating`: as read, without the biases of θ. False where Newton does not converge or a number is not finite.
  bool advance(double period_s, const rom::OperatingState& operating);

  const Eigen::VectorXd& x() const { return x_; }
  /// N x p.
  const Eigen::MatrixXd& sensitivities() const { return sensitivities_; }
  /// Per kelvin of a row on node temperatures, the row on x: row·(T − T_ref) = internal·x.
  Eigen::VectorXd internal_row(const Eigen::VectorXd& row) const;

 private:
  void evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& rate);
  void factor(double weight_s, const Eigen::VectorXd& x);
  bool solve_stage(double weight_s, const Eigen::VectorXd& from, Eigen::VectorXd& stage);
  void solve_sensitivities(double weight_s, const Eigen::VectorXd& stage, Eigen::MatrixXd& from);
  void drive(const Eigen::VectorXd& x);
  void drive_by_environments(const Eigen::VectorXd& x);

  const rom::Network& network_;
  const ParameterModel& parameters_;
  std::shared_ptr<const rom::NetworkOperator> coordinates_;
  Eigen::VectorXd theta_;
  rom::RightHandSide rhs_;
  Sensitivities derivatives_;
  Eigen::MatrixXd sources_;  // L⁻¹B
  bool laws_read_environments_ = false;
  rom::OperatingState operating_;  // corrected
  rom::CorrectionFactors factors_;
  rom::BoundaryValues values_;  // at the last state that was evaluated
  Eigen::VectorXd bias_K_, rises_K_, nodes_K_;
  Eigen::VectorXd x_, rate_;
  Eigen::MatrixXd sensitivities_, drive_, matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  double factored_s_ = 0.0;  // γh of lu_
};

}  // namespace spindle_twin::correction
