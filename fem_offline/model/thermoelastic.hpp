#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/model/surface_rules.hpp"

namespace spindle_twin::fem_offline {

/// The bonded, supported elastic body over the thermal unknowns, axisymmetric: unknowns u_r, u_z per place.
///   K u = G (T − T_ref)
/// Touching places of parts in contact are one; where the meshes of a contact do not match, a stiff surface spring
/// ties them: ∫ k (u_A − u_B)² dA with k = 10⁴ E / h, so stiff that its own give is below 1e-4 of an element's.
struct ElasticBody {
  SparseMatrix stiffness_N_per_m;     ///< reduced unknowns, symmetric positive definite
  SparseMatrix thermal_load_N_per_K;  ///< reduced x FE unknowns
  std::vector<int> reduced;           ///< of 2·place + component; -1 = held at zero
};

/// `stiffness` 2n x 2n and `load` 2n x n are the parts' terms, unbonded. `tie_factor` is the 10⁴ above. Throws
/// rom::InputError if parts are free to move along z.
ElasticBody bond_and_support(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                             const std::vector<DofPlace>& places, const SparseMatrix& stiffness,
                             const SparseMatrix& load, double tie_factor = 1e4);

/// Rows of all deformation outputs over the FE unknowns, one adjoint solve each: K λ = l, row = Gᵀ λ, with l the mean
/// of the displacement over the output's face.
std::vector<FeDeformation> deformation_rows(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                            const ElasticBody& body);

/// u for a field of rises; 2·places long. [m]
Eigen::VectorXd displacements(const ElasticBody& body, const Eigen::VectorXd& rises_K);

}  // namespace spindle_twin::fem_offline
