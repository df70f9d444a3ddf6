#include "fem_offline/model/thermoelastic_stress.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

#include "fem_offline/model/patch_recovery.hpp"

namespace spindle_twin::fem_offline {
namespace {

using Components = Eigen::RowVector4d;  // rr, zz, tt, rz

/// Strains and rise at a quadrature point from the unknowns of one cell.
struct LocalState {
  Components strain = Components::Zero();  // the last is ε_rz, half of the shear angle
  double rise_K = 0.0;
};

LocalState state_at(const dealii::FEValues<2>& values, unsigned q,
                    const std::vector<dealii::types::global_dof_index>& dofs, Geometry geometry,
                    const Eigen::VectorXd& displacements_m, const Eigen::VectorXd& rises_K) {
  LocalState state;
  double u_r = 0.0;
  for (unsigned i = 0; i < values.dofs_per_cell; ++i) {
    const auto dof = static_cast<Eigen::Index>(dofs[i]);
    const dealii::Tensor<1, 2> gradient = values.shape_grad(i, q);
    const double r = displacements_m[2 * dof], z = displacements_m[2 * dof + 1];
    state.strain[0] += gradient[0] * r;
    state.strain[1] += gradient[1] * z;
    state.strain[3] += 0.5 * (gradient[1] * r + gradient[0] * z);
    u_r += values.shape_value(i, q) * r;
    state.rise_K += values.shape_value(i, q) * rises_K[dof];
  }
  if (geometry == Geometry::axisymmetric) state.strain[2] = u_r / values.quadrature_point(q)[0];
  return state;
}

Components stress_of(const LocalState& state, const Material& material) {
  const double nu = material.poisson_ratio;
  const double lambda = material.youngs_modulus_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double mu = material.youngs_modulus_Pa / (2.0 * (1.0 + nu));
  const double mean_Pa =
      lambda * state.strain.head<3>().sum() - (3.0 * lambda + 2.0 * mu) * material.expansion_per_K * state.rise_K;
  Components stress = 2.0 * mu * state.strain;
  stress.head<3>().array() += mean_Pa;
  return stress;
}

}  // namespace

Eigen::MatrixXd nodal_stresses_Pa(const Discretisation<2>& discretisation, const Spindle& spindle,
                                  const Eigen::VectorXd& displacements_m, const Eigen::VectorXd& rises_K) {
  const auto& element = discretisation.element;
  const dealii::QGauss<2> gauss(element.degree);
  dealii::FEValues<2> values(discretisation.mapping, element, gauss,
                             dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points);
  std::vector<Eigen::MatrixXd> samples;
  std::vector<dealii::types::global_dof_index> dofs(element.n_dofs_per_cell());
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    const Material& material = spindle.materials[spindle.parts[cell->material_id()].material];
    Eigen::MatrixXd& at_gauss = samples.emplace_back(gauss.size(), 4);
    for (const unsigned q : values.quadrature_point_indices()) {
      at_gauss.row(q) =
          stress_of(state_at(values, q, dofs, discretisation.geometry, displacements_m, rises_K), material);
    }
  }
  return recovered_at_places(discretisation, samples);
}

}  // namespace spindle_twin::fem_offline
