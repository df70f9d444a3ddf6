#pragma once

#include <Eigen/Core>
#include <cmath>

namespace spindle_twin::fem_offline {

/// Elastic stress, tension positive; the hoop component is the one out of plane when planar.
struct Stress {
  double rr_Pa = 0.0, zz_Pa = 0.0, tt_Pa = 0.0, rz_Pa = 0.0;
};

/// From a row rr, zz, tt, rz.
inline Stress stress_from(const Eigen::RowVector4d& row_Pa) { return {row_Pa[0], row_Pa[1], row_Pa[2], row_Pa[3]}; }

/// √(½[(σ_rr − σ_zz)² + (σ_zz − σ_tt)² + (σ_tt − σ_rr)²] + 3σ_rz²)
inline double von_mises_Pa(const Stress& stress) {
  const double rz = stress.rr_Pa - stress.zz_Pa, zt = stress.zz_Pa - stress.tt_Pa, tr = stress.tt_Pa - stress.rr_Pa;
  return std::sqrt(0.5 * (rz * rz + zt * zt + tr * tr) + 3.0 * stress.rz_Pa * stress.rz_Pa);
}

}  // namespace spindle_twin::fem_offline
