#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "correction/estimator/parameters.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::correction {

/// What the sensitivities need to know of a period in which the inputs were held.
struct HeldInterval {
  double period_s = 0.0;
  double speed_rpm = 0.0;
  const Eigen::VectorXd& start_K;  ///< node temperatures at the start of the period
  const Eigen::VectorXd& end_K;
  const rom::BoundaryValues& values;  ///< with all corrections in them
  const Eigen::VectorXd& theta;
};

/// S = dx/dθ of the network in its internal coordinates x (rom::NetworkOperator), carried along with the model:
///   dS/dt = −(K̃ + Σ_f β q_f b_f b_fᵀ) S + D        b_f = L⁻¹B's column of a friction heat, whose loss of heat with its
///                                                  own rise is one more conductance
///                                                  (of a heat with a physical law −dq_f/dT stands for β q_f)
///   D: heat i          q_i b_i
///      conductance j   −g_j F̃_j (F̃_jᵀ x − F_jᵀ1 (T_env − T_ref))
///      environment e   Σ_j g_j F̃_j F_jᵀ1
///      β               −Σ_f q_f rise_f b_f
///      exponent i      ln(|n|/n_ref) q_i b_i
///      group g         Lᵀ 1_g / C_g, of a heat in W that no source explains
///      capacity i      −dx_i/dt, the mean over the period; of factors c on the capacities every row of the equation
///                      above is divided by its c
/// by SDIRK2 (γ = 1 − 1/√2, L-stable, stiffly accurate), one factor and two pairs of triangular solves a period:
///   (c + γhA) Y₁ = c S + γhD,   (c + γhA) S' = c (S + (1 − γ)/γ (Y₁ − S)) + γhD,   c = 1 without such factors
/// D is taken in the middle of the period. S is stored as Sᵀ (p x N): a state's sensitivities lie together, and
/// a block of states, which substitution works on, is one piece of memory. With
/// coolant circuits the liquid's way from segment to segment goes in at the old S (explicitly).
class Sensitivities {
 public:
  /// Allocates; nothing else here does.
  Sensitivities(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> the_operator,
                const ParameterModel& parameters);

  /// At the start: nothing but the start itself has had an effect. May run in the cycle.
  void start(const ParameterModel& parameters);
  /// The start is now, whatever has been: the effects of all start parameters begin anew. May run in the cycle.
  void restart(const ParameterModel& parameters);
  /// This parameter has had no effect until now. May run in the cycle.
  void clear(Eigen::Index parameter) { transposed_.row(parameter).setZero(); }
  /// From now on the first start parameter has had this effect at the nodes. [K per unit of it]
  void set_start(const Eigen::VectorXd& column_K, const ParameterModel& parameters);
  /// Forgets nothing on failure: returns false and leaves S when the factor is not positive definite.
  bool advance(const HeldInterval& held, const ParameterModel& parameters);
  /// D of the middle of the period, N x p, for who steps S itself; with start_K and end_K the same, that of these
  /// temperatures, and 0 of the capacities. S stays.
  Eigen::Ref<const Eigen::MatrixXd> drive_at(const HeldInterval& held, const ParameterModel& parameters) {
    drive(held, parameters);
    return drive_.leftCols(count_);
  }

  /// Per kelvin of a row on node temperatures, the row on x: row·(T − T_ref) = internal·x.
  void internal_row(const Eigen::VectorXd& row, Eigen::VectorXd& internal) const;
  void to_internal(const Eigen::VectorXd& nodes_K, Eigen::VectorXd& x) const { operator_->to_internal(nodes_K, x); }
  /// d(row·T)/dθ for a row on x.
  void of_row(const Eigen::Ref<const Eigen::VectorXd>& internal, Eigen::VectorXd& sensitivity) {
    padded_.noalias() = transposed_ * internal;
    sensitivity = padded_.head(sensitivity.size());
  }
  /// T += dT of a step in θ.
  void correct(const Eigen::VectorXd& theta_step, Eigen::VectorXd& nodes_K);

  /// Rises of the sources above the reference temperature: b·T.
  void source_rises(const Eigen::VectorXd& nodes_K, Eigen::VectorXd& rises_K) const;

  /// dT/dθ, N x p. Allocates.
  Eigen::MatrixXd in_kelvin() const;
  /// Sᵀ, below it rows of zeros that fill a multiple of four.
  const Eigen::MatrixXd& transposed() const { return transposed_; }
  void set_transposed(const Eigen::MatrixXd& transposed) { transposed_ = transposed; }

 private:
  void add_law_slopes(const HeldInterval& held);
  void set_factors(const rom::Network& network);
  void drive(const HeldInterval& held, const ParameterModel& parameters);
  void drive_by_heats(const HeldInterval& held, const ParameterModel& parameters);
  void drive_by_conductances(const HeldInterval& held, const ParameterModel& parameters);
  void drive_by_coolant(const HeldInterval& held, const ParameterModel& parameters);
  void weaken_by_coolant(const HeldInterval& held, const ParameterModel& parameters);
  void substitute(Eigen::MatrixXd& right_side) const;

  std::shared_ptr<const rom::NetworkOperator> operator_;
  const rom::Network* network_;
  Eigen::MatrixXd capacity_root_;                   // L
  std::shared_ptr<const Eigen::MatrixXd> factors_;  // all L⁻¹F_j side by side; copies share it
  std::vector<Eigen::Index> first_;                 // column of F_j in them
  Eigen::VectorXd column_sums_;                     // F_jᵀ1, likewise
  Eigen::MatrixXd films_;                           // L⁻¹F_j F_jᵀ1, 0 for a conductance without environment
  Eigen::MatrixXd sources_;                         // L⁻¹B
  Eigen::MatrixXd source_rows_;                     // Bᵀ, sources x N
  Eigen::MatrixXd starts_;                          // start shapes in x, shapes x N
  Eigen::MatrixXd group_heats_;                     // L⁻¹C1_g/C_g = Lᵀ1_g/C_g, N x groups
  Eigen::VectorXd inertia_;                         // c, empty without capacity parameters
  Eigen::Index count_ = 0;                          // p
  Eigen::VectorXd padded_;
  Eigen::MatrixXd transposed_;       // Sᵀ
  Eigen::MatrixXd drive_;            // D, N x p
  Eigen::MatrixXd stage_, impulse_;  // Y₁ᵀ, γhDᵀ
  Eigen::MatrixXd lower_;            // 1 + γhA, then its factor
  Eigen::VectorXd packed_;
  Eigen::VectorXd mean_K_, x_, rises_K_, shift_;
  Eigen::MatrixXd coupling_, wall_sensitivity_, fed_sensitivity_;
  Eigen::VectorXd wall_rises_K_, unused_drive_;
  rom::BoundaryValues law_values_;
  Eigen::VectorXd law_inputs_;
  Eigen::MatrixXd law_slopes_;
};

}  // namespace spindle_twin::correction
