#pragma once

#include <memory>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {

/// K T = f with K = K₀ + Σ gⱼ Kⱼ, and the coolant circuits as channels (rom::CoolantCircuit). [K]
/// A model with an imposed temperature gives that one back.
Eigen::VectorXd solve_steady(const AffineModel& model, const rom::BoundaryValues& values);

/// Sum of heat sources and net heat that leaves to the environments, Σⱼ gⱼ 1ᵀKⱼ(T − T_env), and to the circuits. [W]
struct HeatBalance {
  double heat_in_W = 0.0;
  double heat_out_W = 0.0;
  double heat_through_W = 0.0;  ///< sources and what flows in from outside; of steady_heat_balance only
};
HeatBalance heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K);

/// The same of a steady field, to rounding also where temperatures are prescribed: the heat through those faces is what
/// the equations of their unknowns leave over (the reaction), for the drop of temperature over such a film drowns in
/// the digits of an absolute temperature.
HeatBalance steady_heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                                const Eigen::VectorXd& temperatures_K);

/// Where a transient starts: every part at its own initial temperature if it has one, all else at `otherwise_K`. [K]
Eigen::VectorXd initial_temperatures(const AffineModel& model, double otherwise_K);

/// Outlet temperature of every coolant circuit and the heat it takes from the walls; empty without circuits.
rom::CoolantOutlets coolant_outlets(const AffineModel& model, const rom::BoundaryValues& values,
                                    const Eigen::VectorXd& temperatures_K);

/// Rules of the transient, both L-stable and stiffly accurate with one factor per step length: SDIRK of order 2 with
/// two solutions per step, and of order 4 with five, for solutions that others are measured against.
enum class FeScheme { order_2, order_4 };

/// Transient FE solution (SDIRK) with a CHOLMOD factor kept per step length and set
/// of conductances; symbolic analysis done once; coolant circuits exactly, by the Woodbury identity per factor. Heats,
/// conductances and environments are held over advance().
class FeStepper {
 public:
  /// Starts at initial_temperatures with the reference temperature elsewhere. `analysed`: of a matrix of this model,
  /// whose analysis serves here too; it must outlive this. null: one of its own.
  explicit FeStepper(const AffineModel& model, FeScheme scheme = FeScheme::order_2,
                     const CholeskyAnalysis* analysed = nullptr);
  ~FeStepper();
  FeStepper(FeStepper&&) noexcept;
  FeStepper& operator=(FeStepper&&) noexcept;

  /// Keeps no more factors than these, at least 1, the most recent; 16 unless said otherwise, for two operating states
  /// that alternate with all their step lengths. About 10 MB each with 20 000 unknowns.
  void keep_factors(std::size_t most);
  void set_temperatures(const Eigen::VectorXd& temperatures_K);
  void set_uniform_temperature(double temperature_K);
  /// Advances by period_s in steps no longer than max_step_s. After a jump of heats or conductances the first steps are
  /// shorter.
  void advance(double period_s, double max_step_s, const rom::BoundaryValues& values);
  /// The same in steps that each err by no more than `tolerance_K` anywhere, by the embedded rule of order 3: short
  /// where much happens, period_s at most and a 4096th of it at least. Only with FeScheme::order_4, else
  /// std::logic_error.
  void advance_within(double period_s, double tolerance_K, const rom::BoundaryValues& values);
  const Eigen::VectorXd& temperatures_K() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
