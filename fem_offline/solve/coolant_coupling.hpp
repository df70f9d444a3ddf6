#pragma once

#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {

/// What the liquid carries from segment to segment of the coolant circuits. The affine terms let every segment see its
/// circuit's inlet; the heat that they lack is
///   + S Γ U (R T − T_inlet),   S = [K_s 1] (n x M), Γ = diag(g_s), R = rows K_s1 / A_s (area means of the walls),
/// U of rom::coolant_upstream. Rank M, not symmetric; without circuits nothing at all.
class CoolantCoupling {
 public:
  explicit CoolantCoupling(const AffineModel& model);

  bool empty() const { return segments_.count() == 0; }
  void hold(const rom::BoundaryValues& values);

  /// Area means of the wetted walls, one per segment; a column for each field.
  Eigen::MatrixXd walls_K(const Eigen::Ref<const Eigen::MatrixXd>& temperatures_K) const;
  /// Temperature of the liquid that enters each segment, T_inlet + U (R T − T_inlet); one per segment.
  Eigen::VectorXd entering_K(const Eigen::VectorXd& temperatures_K) const;
  /// S Γ: heat that each segment's wall gets per kelvin of its own inlet. [W/K]
  Eigen::MatrixXd heat_per_inlet_W_per_K() const;
  /// U R T; a column for each field. [K]
  Eigen::MatrixXd fed_K(const Eigen::Ref<const Eigen::MatrixXd>& temperatures_K) const {
    return upstream_ * walls_K(temperatures_K);
  }

  /// heat += S Γ U R T; a column for each field.
  void add_heat(const Eigen::Ref<const Eigen::MatrixXd>& temperatures_K, Eigen::Ref<Eigen::MatrixXd> heat_W) const;
  /// load −= S Γ U 1 (T_inlet − datum), for temperatures counted from `datum_K`.
  void add_load(double datum_K, Eigen::VectorXd& load_W) const;

  const rom::CoolantSegments& segments() const { return segments_; }

 private:
  rom::CoolantSegments segments_;
  SparseMatrix wetted_m2_;  // S
  Eigen::VectorXd film_W_per_m2K_, inlet_K_;
  Eigen::MatrixXd upstream_;
};

/// Factor of A − factor · S Γ U R with A symmetric: Cholesky of A, and the circuits by the Woodbury identity, exact and
/// M solves dearer. Keeps what `coupling` held when it was made.
class CoupledFactor {
 public:
  CoupledFactor(CholeskyFactor symmetric, const CoolantCoupling& coupling, double factor);

  const CholeskyFactor& symmetric() const { return symmetric_; }
  /// `coupling` must hold what it held at the construction.
  void solve(const Eigen::VectorXd& right_hand_side, const CoolantCoupling& coupling, Eigen::VectorXd& solution);
  /// All columns in one pass over the factor; the same condition.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, const CoolantCoupling& coupling);

 private:
  CholeskyFactor symmetric_;
  double factor_;
  Eigen::MatrixXd responses_;  // A⁻¹ S Γ
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;
};

}  // namespace spindle_twin::fem_offline
