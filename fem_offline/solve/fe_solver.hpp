#pragma once

#include <memory>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// K T = f with K = K₀ + Σ gⱼ Kⱼ. [K]
Eigen::VectorXd solve_steady(const AffineModel& model, const rom::BoundaryValues& values);

/// Sum of heat sources and net heat that leaves to the environments, Σⱼ gⱼ 1ᵀKⱼ(T − T_env). [W]
struct HeatBalance {
  double heat_in_W = 0.0;
  double heat_out_W = 0.0;
};
HeatBalance heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K);

/// Transient FE solution, SDIRK2 (γ = 1 − 1/√2, L-stable, order 2) with a CHOLMOD factor kept per step length and set
/// of conductances; symbolic analysis done once. Heats, conductances and environments are held over advance().
class FeStepper {
 public:
  explicit FeStepper(const AffineModel& model);
  ~FeStepper();
  FeStepper(FeStepper&&) noexcept;
  FeStepper& operator=(FeStepper&&) noexcept;

  void set_temperatures(const Eigen::VectorXd& temperatures_K);
  void set_uniform_temperature(double temperature_K);
  /// Advances by period_s in steps no longer than max_step_s. After a jump of heats or conductances the first steps are
  /// shorter.
  void advance(double period_s, double max_step_s, const rom::BoundaryValues& values);
  const Eigen::VectorXd& temperatures_K() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
