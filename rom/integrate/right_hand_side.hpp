#pragma once

#include <Eigen/Core>
#include <memory>

#include "rom/boundaries.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom {

/// f(x) = −K̃ x + u with the inputs of one cycle held; its Jacobian is −K̃. With coolant circuits f(x) = −K̃x + u + PX̃Pᵀx
/// (NetworkOperator). One per stepper, over a shared operator.
///
/// Physical laws either stay at what the inputs say (hold), or follow the state inside the step (follow):
///   f(x) = −K̃x − Σⱼ (gⱼ(z) − gⱼ) F̃ⱼ F̃ⱼᵀ x + u(q(z), g(z)) + P X̃(g(z)) Pᵀ x,   z = rowsᵀ x + offset, F̃ = L⁻¹F
/// Factors cᵢ on the nodes' capacities (diagonal C only) divide row i: evaluate() gives f(x)ᵢ / cᵢ and linearise() its
/// rows over cᵢ; full(), lower(), feedback() and drive() are those of the capacities as written, and
/// inverse_capacity() brings the rest.
/// gⱼ of a law is that of an earlier period as long as gⱼ(z) is within a fiftieth of it: K̃ need not be assembled for
/// less.
///   ∂f/∂x = −K̃ − Σⱼ (gⱼ(z) − gⱼ) F̃ⱼF̃ⱼᵀ + PX̃Pᵀ + Σᵢ L⁻¹Bᵢ (∂qᵢ/∂z rowsᵀ) + Σⱼ ∂f/∂gⱼ (∂gⱼ/∂z rowsᵀ)
class RightHandSide {
 public:
  explicit RightHandSide(std::shared_ptr<const NetworkOperator> network);

  const NetworkOperator& network() const { return *network_; }

  /// Takes over the inputs of the next period, which accepts() must have found good; assembles K̃ only if a conductance
  /// differs from the last ones. Returns whether the Jacobian changed. Cycle-safe.
  bool hold(const BoundaryValues& values);

  /// 1 / cᵢ of the capacity factors held; empty where the inputs give none.
  const Eigen::VectorXd& inverse_capacity() const { return scaled_ ? inverse_capacity_ : no_factors_; }

  /// Those in K̃.
  const Eigen::VectorXd& conductance_W_per_m2K() const { return assembled_for_W_per_m2K_; }

  /// The same, and laws follow the state from x on if the inputs say so and there are any. Cycle-safe.
  bool follow(const BoundaryValues& values, const double* x);
  bool following() const { return following_; }

  /// dx = f(x). Cycle-safe; x and dx hold N numbers each and do not overlap.
  void evaluate(const double* x, double* dx) const;

  /// Whether a circuit makes the Jacobian −K̃ + PX̃Pᵀ, which is not symmetric.
  bool coupled() const { return coupling_.size() > 0; }
  /// target = K̃ − PX̃Pᵀ in full, of held inputs. Cycle-safe for `target` of N x N.
  void full(Eigen::Ref<Eigen::MatrixXd> target) const;
  /// target = −∂f/∂x at x, laws included. Cycle-safe likewise.
  void linearise(const double* x, Eigen::Ref<Eigen::MatrixXd> target) const;

  /// Y with −∂f/∂x ≈ K̃ − W Y Wᵀ, W = NetworkOperator::feedback_columns(): coupling of the circuits, and how the heats
  /// of laws follow the readings at x. What the slopes of conductances add is left to Newton's iterations. Cycle-safe.
  const Eigen::MatrixXd& feedback(const double* x) const;

  /// X̃, empty without circuits.
  const Eigen::MatrixXd& coupling() const { return coupling_; }
  /// K̃, lower triangle valid.
  const Eigen::MatrixXd& lower() const { return lower_; }
  const Eigen::VectorXd& drive() const { return drive_; }

 private:
  void assemble(const Eigen::VectorXd& conductance_W_per_m2K);
  bool set_capacities(const Eigen::VectorXd& capacity_factor);
  void follow_to(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  void add_law_slopes(const Eigen::Ref<const Eigen::VectorXd>& state, Eigen::Ref<Eigen::MatrixXd> target) const;
  void set_conductance_slope(const LawTerm& term, const Eigen::Ref<const Eigen::VectorXd>& x) const;

  std::shared_ptr<const NetworkOperator> network_;
  Eigen::VectorXd assembled_for_W_per_m2K_;
  bool assembled_ = false;
  // Mostly films move and contacts do not, so K̃ is made from an earlier one and the terms that differ from it.
  Eigen::VectorXd base_W_per_m2K_;
  Eigen::VectorXd base_packed_, packed_;
  Eigen::MatrixXd lower_;
  Eigen::VectorXd drive_;
  Eigen::VectorXd held_coolant_W_per_K_;
  bool has_node_heat_ = false;
  Eigen::VectorXd node_drive_;  // L⁻¹ node heat
  bool scaled_ = false;
  Eigen::VectorXd capacity_factor_, inverse_capacity_;
  Eigen::VectorXd no_factors_;                 // empty
  mutable Eigen::MatrixXd coupling_;           // X̃
  mutable Eigen::VectorXd walls_;              // Pᵀ x; scratch
  mutable Eigen::VectorXd fed_;                // X̃ Pᵀ x; scratch
  mutable Eigen::MatrixXd walls_by_coupling_;  // P X̃; scratch
  // Laws at the state last asked for.
  bool following_ = false;
  BoundaryValues base_;
  mutable BoundaryValues now_;
  mutable Eigen::MatrixXd feedback_;   // Y
  mutable Eigen::VectorXd readings_;   // z
  mutable Eigen::MatrixXd slopes_;     // laws x law_readings
  mutable Eigen::VectorXd now_drive_;  // u(q(z), g(z))
  mutable Eigen::VectorXd through_;    // F̃ᵀx of one law; scratch
  mutable Eigen::VectorXd by_value_;   // ∂f/∂gⱼ; scratch
  mutable Eigen::VectorXd by_state_;   // rows · slopes of one law; scratch
  mutable Eigen::VectorXd wall_rise_K_, weights_;
};

/// Whether every input is a finite number. Cycle-safe.
bool all_finite(const BoundaryValues& values);

/// Whether node heats and capacity factors are none or one per node, and capacity factors above 0 and only given where
/// the capacity matrix is diagonal. Cycle-safe.
bool accepts(const NetworkOperator& network, const BoundaryValues& values);

}  // namespace spindle_twin::rom
