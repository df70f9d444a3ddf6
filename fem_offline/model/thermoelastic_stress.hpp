#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {

/// Stress at every FE unknown's place, n x 4: σ_rr, σ_zz, σ_tt, σ_rz in Pa, tension positive;
///   σ = λ tr(ε) 1 + 2μ ε − (3λ + 2μ) α (T − T_ref) 1.
/// Taken at the degree² Gauss points of each element, where a displacement of that degree gives its best strains, and
/// carried to the places part by part by recovered_at_places. `displacements_m` is 2n long, `rises_K` n.
Eigen::MatrixXd nodal_stresses_Pa(const Discretisation<2>& discretisation, const Spindle& spindle,
                                  const Eigen::VectorXd& displacements_m, const Eigen::VectorXd& rises_K);

}  // namespace spindle_twin::fem_offline
