#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// Right-hand sides of the snapshots.
struct Loads {
  Eigen::MatrixXd heat_W;                ///< one column per source at the largest heat it makes in the box
  std::vector<Eigen::VectorXd> film_m2;  ///< Kⱼ1 per conductance; empty for exchange between bodies
  std::vector<int> film_column;          ///< per conductance, -1 for exchange between bodies
  int film_columns = 0;  ///< one per environment, then one per segment of a coolant circuit, whose liquid has its own
  Eigen::MatrixXd outputs;  ///< Lᵀ of key points, deformations and contact pressures, scaled

  /// [heats, one column per environment or coolant segment: Σⱼ gⱼ Kⱼ1 · environment_step_K]. Solutions with coolant
  /// that warms up on its way lie in the span of these (Woodbury), so that K stays symmetric here.
  Eigen::MatrixXd primal(const Eigen::VectorXd& conductance_W_per_m2K) const;
};

/// Step of an environment's temperature to which its snapshots are scaled.
inline constexpr double environment_step_K = 10.0;

/// Loads of the FE model; the outputs are not scaled yet.
Loads make_loads(const AffineModel& model, double speed_high_rpm, double load_high);

/// Takes the mean over the rows off every column: what is left of it beside the constant vector.
void remove_constant(Eigen::MatrixXd& columns);

}  // namespace spindle_twin::fem_offline
