#include "fem_offline/model/volume_terms.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

namespace spindle_twin::fem_offline {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

SparseMatrix assembled(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

/// Normal strains first, then shears; the hoop strain is normal number 2 of a body of revolution, 0 in plane strain.
constexpr int strain_count = 6;
using Strains = Eigen::Matrix<double, strain_count, Eigen::Dynamic>;

template <int dim>
void fill_strains(const dealii::FEValues<dim>& values, unsigned q, Geometry geometry, Strains& strains) {
  strains.setZero();
  for (unsigned i = 0; i < values.dofs_per_cell; ++i) {
    const dealii::Tensor<1, dim> gradient = values.shape_grad(i, q);
    for (int c = 0; c < dim; ++c) strains(c, dim * static_cast<int>(i) + c) = gradient[static_cast<unsigned>(c)];
    int shear = 3;
    for (int a = 0; a < dim; ++a) {
      for (int b = a + 1; b < dim; ++b, ++shear) {
        strains(shear, dim * static_cast<int>(i) + a) = gradient[static_cast<unsigned>(b)];
        strains(shear, dim * static_cast<int>(i) + b) = gradient[static_cast<unsigned>(a)];
      }
    }
    if (dim == 2 && geometry == Geometry::axisymmetric) {
      strains(2, dim * static_cast<int>(i)) = values.shape_value(i, q) / values.quadrature_point(q)[0];
    }
  }
}

Eigen::Matrix<double, strain_count, strain_count> isotropic_stiffness(const Material& material) {
  const double nu = material.poisson_ratio;
  const double lambda = material.youngs_modulus_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double mu = material.youngs_modulus_Pa / (2.0 * (1.0 + nu));
  Eigen::Matrix<double, strain_count, strain_count> stiffness;
  stiffness.setZero();
  stiffness.topLeftCorner<3, 3>().setConstant(lambda);
  stiffness.diagonal().head<3>().array() += 2.0 * mu;
  stiffness.diagonal().tail<3>().setConstant(mu);
  return stiffness;
}

}  // namespace

template <int dim>
VolumeTerms volume_terms(const Discretisation<dim>& discretisation, const Spindle& spindle) {
  const auto& element = discretisation.element;
  const auto n = static_cast<Eigen::Index>(discretisation.dof_handler.n_dofs());
  const unsigned per_cell = element.n_dofs_per_cell();
  dealii::FEValues<dim> values(
      discretisation.mapping, element, dealii::QGauss<dim>(element.degree + 2),
      dealii::update_values | dealii::update_gradients | dealii::update_JxW_values | dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs(per_cell);
  VolumeTerms terms;
  terms.function_volume_m3.assign(spindle.parts.size(), Eigen::VectorXd::Zero(n));
  Triplets capacity, conduction;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    const std::size_t part = cell->material_id();
    const Material& material = spindle.materials[spindle.parts[part].material];
    dealii::Tensor<1, dim> conductivity;
    for (unsigned c = 0; c < dim; ++c) conductivity[c] = material.conductivity_r_W_per_mK;
    conductivity[dim - 1] = material.conductivity_z_W_per_mK;
    const double heat_capacity_J_per_m3K = material.density_kg_per_m3 * material.heat_capacity_J_per_kgK;
    Eigen::MatrixXd cell_capacity = Eigen::MatrixXd::Zero(per_cell, per_cell);
    Eigen::MatrixXd cell_conduction = Eigen::MatrixXd::Zero(per_cell, per_cell);
    for (const unsigned q : values.quadrature_point_indices()) {
      const double weight_m3 =
          values.JxW(q) * revolution_factor<dim>(discretisation.geometry, values.quadrature_point(q));
      for (unsigned i = 0; i < per_cell; ++i) {
        terms.function_volume_m3[part][static_cast<Eigen::Index>(dofs[i])] += weight_m3 * values.shape_value(i, q);
        for (unsigned j = 0; j < per_cell; ++j) {
          cell_capacity(i, j) +=
              weight_m3 * heat_capacity_J_per_m3K * values.shape_value(i, q) * values.shape_value(j, q);
          double flux = 0.0;
          for (unsigned c = 0; c < dim; ++c) {
            flux += conductivity[c] * values.shape_grad(i, q)[c] * values.shape_grad(j, q)[c];
          }
          cell_conduction(i, j) += weight_m3 * flux;
        }
      }
    }
    for (unsigned i = 0; i < per_cell; ++i) {
      for (unsigned j = 0; j < per_cell; ++j) {
        capacity.emplace_back(dofs[i], dofs[j], cell_capacity(i, j));
        conduction.emplace_back(dofs[i], dofs[j], cell_conduction(i, j));
      }
    }
  }
  terms.capacity_J_per_K = assembled(n, n, capacity);
  terms.conduction_W_per_K = assembled(n, n, conduction);
  return terms;
}

template <int dim>
ElasticTerms elastic_terms(const Discretisation<dim>& discretisation, const Spindle& spindle) {
  const auto& element = discretisation.element;
  const auto n = static_cast<Eigen::Index>(discretisation.dof_handler.n_dofs());
  const unsigned per_cell = element.n_dofs_per_cell();
  dealii::FEValues<dim> values(
      discretisation.mapping, element, dealii::QGauss<dim>(element.degree + 2),
      dealii::update_values | dealii::update_gradients | dealii::update_JxW_values | dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs(per_cell);
  Strains strains(strain_count, static_cast<Eigen::Index>(dim * per_cell));
  Eigen::Matrix<double, strain_count, 1> isotropic_strain;
  isotropic_strain << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
  Triplets stiffness, thermal_load;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    const Material& material = spindle.materials[spindle.parts[cell->material_id()].material];
    const auto stress_per_strain = isotropic_stiffness(material);
    Eigen::MatrixXd cell_stiffness = Eigen::MatrixXd::Zero(strains.cols(), strains.cols());
    Eigen::MatrixXd cell_load = Eigen::MatrixXd::Zero(strains.cols(), per_cell);
    Eigen::RowVectorXd shape(per_cell);
    for (const unsigned q : values.quadrature_point_indices()) {
      const double weight_m3 =
          values.JxW(q) * revolution_factor<dim>(discretisation.geometry, values.quadrature_point(q));
      fill_strains<dim>(values, q, discretisation.geometry, strains);
      for (unsigned i = 0; i < per_cell; ++i) shape[i] = values.shape_value(i, q);
      const Eigen::MatrixXd weighted_stress = weight_m3 * (stress_per_strain * strains);
      cell_stiffness.noalias() += strains.transpose() * weighted_stress;
      cell_load.noalias() += material.expansion_per_K * (weighted_stress.transpose() * isotropic_strain) * shape;
    }
    const auto global = [&](int local) { return dim * static_cast<int>(dofs[local / dim]) + local % dim; };
    for (int i = 0; i < strains.cols(); ++i) {
      for (int j = 0; j < strains.cols(); ++j) stiffness.emplace_back(global(i), global(j), cell_stiffness(i, j));
      for (unsigned j = 0; j < per_cell; ++j) {
        thermal_load.emplace_back(global(i), static_cast<int>(dofs[j]), cell_load(i, j));
      }
    }
  }
  return {assembled(dim * n, dim * n, stiffness), assembled(dim * n, n, thermal_load)};
}

template VolumeTerms volume_terms<2>(const Discretisation<2>&, const Spindle&);
template ElasticTerms elastic_terms<2>(const Discretisation<2>&, const Spindle&);

}  // namespace spindle_twin::fem_offline
