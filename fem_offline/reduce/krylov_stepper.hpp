#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// A part of a stretch, at the end of which the field is wanted.
struct StretchPart {
  double duration_s = 0.0;
  rom::BoundaryValues values;  ///< held
};

/// For comparisons with a network: well below a hundredth of what part maxima may err by. [K]
inline constexpr double tolerance_in_time_K = 5e-4;

/// Whether two parts may stand in one stretch: same conductances, heats and coolant flows. Surroundings may differ.
bool of_one_stretch(const rom::BoundaryValues& one, const rom::BoundaryValues& other);

/// Transient FE solution over stretches in which conductances, heats and flows are held: C ΔT' = r(t) − A ΔT for the
/// change ΔT since the stretch began, by Galerkin's projection on a rational Krylov space of r. In the space the
/// solution is exact in time. The space grows until that changes no temperature of the field at the ends of four parts
/// by more than a tolerance: an estimate of what a stretch errs by, not a bound. A. Ruhe: Rational Krylov sequence
/// methods for eigenvalue computation, Linear Algebra Appl. 58 (1984) 391-405; V. Druskin, V. Simoncini: Adaptive
/// rational Krylov subspaces for large-scale dynamical systems, Syst. Control Lett. 60 (2011) 546-560.
class KrylovStepper {
 public:
  /// `analysed`: of a matrix of this model, whose analysis serves here; it must outlive this. `tolerance_K`: above 0.
  KrylovStepper(const AffineModel& model, const CholeskyAnalysis& analysed, double tolerance_K);
  ~KrylovStepper();

  void set_temperatures(const Eigen::VectorXd& temperatures_K);
  const Eigen::VectorXd& temperatures_K() const;

  /// Runs through a stretch, not empty, and gives `visit(part, temperatures_K)` the field at the end of each part.
  void advance(std::span<const StretchPart> parts,
               const std::function<void(std::size_t part, const Eigen::VectorXd& temperatures_K)>& visit);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::fem_offline
