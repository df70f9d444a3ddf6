#pragma once

#include <vector>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// K = K₀ + Σ gⱼ Kⱼ and C on one union pattern (lower triangles), so that a new set of conductances or a new step
/// length costs no symbolic work.
class ThermalSystem {
 public:
  explicit ThermalSystem(const AffineModel& model);

  void set_conductances(const Eigen::VectorXd& conductance_W_per_m2K);

  const SparseMatrix& conduction_lower() const { return conduction_; }
  const SparseMatrix& capacity_lower() const { return capacity_; }
  /// capacity + factor · conduction, lower triangle.
  SparseMatrix combined_lower(double factor) const;

  /// B q + Σ gⱼ (Kⱼ 1)(T_env(j) − datum), for temperatures counted from `datum_K`. [W]
  Eigen::VectorXd load_W(const rom::BoundaryValues& values, double datum_K) const;

 private:
  /// Values of one matrix at their positions in the union pattern.
  struct Scatter {
    std::vector<Eigen::Index> positions;
    std::vector<double> values;
  };
  Scatter scatter_of(const SparseMatrix& matrix) const;
  void add(const Scatter& scatter, double factor, SparseMatrix& to) const;

  const AffineModel* model_;
  SparseMatrix conduction_, capacity_;
  Scatter constant_;
  std::vector<Scatter> terms_;
  SparseMatrix wetted_m2_;  ///< a column Kⱼ 1 for each film to an environment, of the others one without entries
};

}  // namespace spindle_twin::fem_offline
