#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {

/// Integrals over the parts, n FE unknowns:
///   capacity    ∫ ρ c N_i N_j dV                     [J/K]
///   conduction  ∫ (k_r ∂_r N_i ∂_r N_j + k_z ∂_z N_i ∂_z N_j) dV   [W/K]
struct VolumeTerms {
  SparseMatrix capacity_J_per_K;
  SparseMatrix conduction_W_per_K;
  std::vector<Eigen::VectorXd> function_volume_m3;  ///< per part: ∫ N_i dV; sums to its volume
};

template <int dim>
VolumeTerms volume_terms(const Discretisation<dim>& discretisation, const Spindle& spindle);

/// Small-strain elasticity with thermal strain α ΔT, unknown c of place i at dim·i + c:
///   K_el = ∫ Bᵀ D B dV,  G = ∫ Bᵀ D m α N dV,  K_el u = G (T − T_ref)
/// with the hoop strain u_r/r in two dimensions.
struct ElasticTerms {
  SparseMatrix stiffness_N_per_m;     ///< dim·n x dim·n
  SparseMatrix thermal_load_N_per_K;  ///< dim·n x n
};

template <int dim>
ElasticTerms elastic_terms(const Discretisation<dim>& discretisation, const Spindle& spindle);

}  // namespace spindle_twin::fem_offline
