#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/volume_terms.hpp"

namespace spindle_twin::fem_offline {

/// The bonded, supported elastic body over the thermal unknowns, axisymmetric or plane strain: unknowns u_r, u_z per
/// place.
///   K u = G (T − T_ref)
/// Touching places of parts in contact are one; where the meshes of a contact do not match, a stiff surface spring
/// ties them: ∫ k (u_A − u_B)² dA with k = 10⁴ E / h, so stiff that its own give is below 1e-4 of an element's.
/// A spring support of stiffness s adds s/A ∫ u² dA; a face that stays plane has one unknown u_z.
struct ElasticBody {
  SparseMatrix stiffness_N_per_m;     ///< reduced unknowns, symmetric positive definite; lower triangle only
  SparseMatrix thermal_load_N_per_K;  ///< reduced x FE unknowns
  std::vector<int> reduced;           ///< of 2·place + component; -1 = held at zero
};

/// `terms` are the parts' own, unbonded. `tie_factor` is the 10⁴ above. Throws rom::InputError naming a part that is
/// free to move as a rigid body.
ElasticBody bond_and_support(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                             const std::vector<DofPlace>& places, const ElasticTerms& terms, double tie_factor = 1e4);

/// An elastic body with its CHOLMOD factor. One thread at a time.
class ElasticSolver {
 public:
  /// Takes the matrices over.
  explicit ElasticSolver(ElasticBody&& body);
  ~ElasticSolver();
  ElasticSolver(ElasticSolver&&) noexcept;
  ElasticSolver& operator=(ElasticSolver&&) noexcept;

  const ElasticBody& body() const;
  /// K⁻¹ loads over the reduced unknowns, one column each. [m] for loads in N
  Eigen::MatrixXd solve(const Eigen::MatrixXd& loads_N) const;
  /// u for a field of rises; 2·places long. [m]
  Eigen::VectorXd displacements_m(const Eigen::VectorXd& rises_K) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rows of all deformation outputs over the FE unknowns, one adjoint solve each: K λ = l, row = Gᵀ λ, with l the mean
/// of the displacement over the output's face or its value at the output's point.
std::vector<FeDeformation> deformation_rows(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                            const Discretisation<2>& discretisation, const ElasticSolver& solver);

/// What the mean pressure of one contact takes from the parts' own terms, which need not outlive the bonded body then.
struct ContactForces {
  Eigen::VectorXd stiffness_N_per_m;  ///< K_part v, 2·places long
  Eigen::VectorXd load_N_per_K;       ///< G_partᵀ v, places long
};

/// Of each contact pressure that the description asks for; v: the outward unit normal on the nodes of the contact, half
/// of it on each side, and 0 elsewhere.
std::vector<ContactForces> contact_forces(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                          const std::vector<DofPlace>& places, const ElasticTerms& terms);

/// Mean pressure of contacts, from the forces that the joint carries: the part's internal forces give
/// ∫ n·σ·n dA = vᵀ(K_part u − G_part (T − T_ref)), so
///   p = p_assembly + row · (T − T_ref),  row = −(Gᵀ K⁻¹ K_part − G_partᵀ) v / A,
/// taken as the mean of both sides. One adjoint solve each. At a corner where a contact meets another one, half an
/// element of the neighbour's shear counts in; pressures are positive, a negative sum means that the joint would open.
std::vector<FeContactPressure> contact_pressure_rows(const Spindle& spindle, const SurfaceRules& rules,
                                                     const std::vector<ContactForces>& forces,
                                                     const ElasticSolver& solver);

}  // namespace spindle_twin::fem_offline
