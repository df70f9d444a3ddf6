#pragma once

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/solve/coolant_coupling.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// The FE model under held inputs, for temperatures T counted from a datum:
///   C dT/dt = f − A T,   A = K − S Γ U R (CoolantCoupling),   f = B q + Σ gⱼ (Kⱼ 1)(T_env(j) − datum) + that of
///   circuits
/// For one thread; copies are cheap. `model` must outlive it.
class HeldSystem {
 public:
  explicit HeldSystem(const AffineModel& model);

  /// Holds these conductances, heats, flows and surroundings.
  void hold(const rom::BoundaryValues& values, double datum_K);
  /// K of these conductances alone; heats, flows and surroundings stay.
  void hold_conductances(const Eigen::VectorXd& conductance_W_per_m2K);

  const ThermalSystem& matrices() const { return matrices_; }
  const CoolantCoupling& circuits() const { return circuits_; }

  /// f, one per unknown. [W]
  const Eigen::VectorXd& load_W() const { return load_W_; }
  /// f − A T: what warms each unknown. [W]
  void net_heat_W(const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& heat_W) const;
  /// A T; a column for each field. [W]
  Eigen::MatrixXd conducted_W(const Eigen::MatrixXd& temperatures_K) const;
  /// C T; a column for each field. [J]
  Eigen::MatrixXd stored_J(const Eigen::MatrixXd& temperatures_K) const;

  /// Factor of A. `analysed`: of a matrix of this model; null: analyses it anew. Throws std::runtime_error where K is
  /// not positive definite, as the one below.
  CoupledFactor factor(const CholeskyAnalysis* analysed) const;
  /// Factor of C + step A.
  CoupledFactor factor(double step_s, const CholeskyAnalysis* analysed) const;

 private:
  ThermalSystem matrices_;
  CoolantCoupling circuits_;
  Eigen::VectorXd conductance_W_per_m2K_;  ///< of K; zero before the first
  Eigen::VectorXd load_W_;
};

}  // namespace spindle_twin::fem_offline
