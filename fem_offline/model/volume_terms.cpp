#include "fem_offline/model/volume_terms.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <algorithm>

namespace spindle_twin::fem_offline {
namespace {

/// A matrix that is filled cell by cell. Its entries are known before: blocks of components of every two functions that
/// share a cell. Lists of what each cell adds would take several times its memory.
class CellMatrix {
 public:
  /// Component c of function i is row row_components·i + c, and likewise the columns.
  CellMatrix(const dealii::DynamicSparsityPattern& sharing, int row_components, int column_components) {
    const auto functions = static_cast<int>(sharing.n_rows());
    matrix_.resize(row_components * functions, column_components * functions);
    std::vector<int> starts = {0}, rows;
    rows.reserve(sharing.n_nonzero_elements() * static_cast<std::size_t>(row_components * column_components));
    for (int j = 0; j < functions; ++j) {
      for (int c = 0; c < column_components; ++c) {
        for (auto i = sharing.begin(static_cast<unsigned>(j)); i != sharing.end(static_cast<unsigned>(j)); ++i) {
          for (int r = 0; r < row_components; ++r) rows.push_back(row_components * static_cast<int>(i->column()) + r);
        }
        starts.push_back(static_cast<int>(rows.size()));
      }
    }
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(rows.size()));
    std::copy(starts.begin(), starts.end(), matrix_.outerIndexPtr());
    std::copy(rows.begin(), rows.end(), matrix_.innerIndexPtr());
    matrix_.coeffs().setZero();
  }
  void add(int row, int column, double value) {
    const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column];
    const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + 1];
    matrix_.valuePtr()[std::lower_bound(begin, end, row) - matrix_.innerIndexPtr()] += value;
  }
  SparseMatrix take() { return taken(matrix_); }

 private:
  SparseMatrix matrix_;
};

/// Pairs of functions that share a cell.
template <int dim>
dealii::DynamicSparsityPattern functions_that_share_cells(const Discretisation<dim>& discretisation) {
  dealii::DynamicSparsityPattern sharing(discretisation.dof_handler.n_dofs());
  dealii::DoFTools::make_sparsity_pattern(discretisation.dof_handler, sharing);
  return sharing;
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
  // One column per function, points (times directions) down: every entry of a cell's matrices is a product of two
  // columns.
  const auto columns = static_cast<Eigen::Index>(per_cell);
  const auto points = static_cast<Eigen::Index>(values.n_quadrature_points);
  Eigen::MatrixXd shape(points, columns), gradient(dim * points, columns);
  Eigen::VectorXd weight_m3(points), gradient_weight(dim * points);
  Eigen::MatrixXd weighted_shape(points, columns), weighted_gradient(dim * points, columns);
  const dealii::DynamicSparsityPattern sharing = functions_that_share_cells(discretisation);
  CellMatrix capacity(sharing, 1, 1), conduction(sharing, 1, 1);
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    const std::size_t part = cell->material_id();
    const Material& material = spindle.materials[spindle.parts[part].material];
    const double heat_capacity_J_per_m3K = material.density_kg_per_m3 * material.heat_capacity_J_per_kgK;
    for (const unsigned q : values.quadrature_point_indices()) {
      weight_m3[q] = values.JxW(q) * revolution_factor<dim>(discretisation.geometry, values.quadrature_point(q));
      for (unsigned c = 0; c < dim; ++c) {
        gradient_weight[dim * q + c] =
            weight_m3[q] * (c + 1 < dim ? material.conductivity_r_W_per_mK : material.conductivity_z_W_per_mK);
      }
      for (unsigned i = 0; i < per_cell; ++i) {
        shape(q, i) = values.shape_value(i, q);
        const dealii::Tensor<1, dim> at_point = values.shape_grad(i, q);
        for (unsigned c = 0; c < dim; ++c) gradient(dim * q + c, i) = at_point[c];
      }
    }
    weighted_shape = weight_m3.asDiagonal() * shape;
    weighted_gradient = gradient_weight.asDiagonal() * gradient;
    for (unsigned i = 0; i < per_cell; ++i) {
      terms.function_volume_m3[part][static_cast<Eigen::Index>(dofs[i])] += weighted_shape.col(i).sum();
      for (unsigned j = 0; j <= i; ++j) {
        const double c_ij = heat_capacity_J_per_m3K * weighted_shape.col(i).dot(shape.col(j));
        const double k_ij = weighted_gradient.col(i).dot(gradient.col(j));
        const auto row = static_cast<int>(dofs[i]), column = static_cast<int>(dofs[j]);
        capacity.add(row, column, c_ij);
        conduction.add(row, column, k_ij);
        if (i == j) continue;
        capacity.add(column, row, c_ij);
        conduction.add(column, row, k_ij);
      }
    }
  }
  terms.capacity_J_per_K = capacity.take();
  terms.conduction_W_per_K = conduction.take();
  return terms;
}

template <int dim>
ElasticTerms elastic_terms(const Discretisation<dim>& discretisation, const Spindle& spindle) {
  const auto& element = discretisation.element;
  const unsigned per_cell = element.n_dofs_per_cell();
  dealii::FEValues<dim> values(
      discretisation.mapping, element, dealii::QGauss<dim>(element.degree + 2),
      dealii::update_values | dealii::update_gradients | dealii::update_JxW_values | dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs(per_cell);
  const auto unknowns = dim * static_cast<Eigen::Index>(per_cell);
  const auto points = static_cast<Eigen::Index>(values.n_quadrature_points);
  Strains strains(strain_count, unknowns);
  Eigen::Matrix<double, strain_count, 1> isotropic_strain;
  isotropic_strain << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
  // Points down, so that a cell's matrices are one product each.
  Eigen::MatrixXd strain_at(strain_count * points, unknowns), stress_at(strain_count * points, unknowns);
  Eigen::MatrixXd pressure_at(points, unknowns), shape_at(points, static_cast<Eigen::Index>(per_cell));
  Eigen::MatrixXd cell_stiffness(unknowns, unknowns), cell_load(unknowns, static_cast<Eigen::Index>(per_cell));
  const dealii::DynamicSparsityPattern sharing = functions_that_share_cells(discretisation);
  CellMatrix stiffness(sharing, dim, dim), thermal_load(sharing, dim, 1);
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    const Material& material = spindle.materials[spindle.parts[cell->material_id()].material];
    const auto stress_per_strain = isotropic_stiffness(material);
    for (const unsigned q : values.quadrature_point_indices()) {
      const double weight_m3 =
          values.JxW(q) * revolution_factor<dim>(discretisation.geometry, values.quadrature_point(q));
      fill_strains<dim>(values, q, discretisation.geometry, strains);
      for (unsigned i = 0; i < per_cell; ++i) shape_at(q, i) = values.shape_value(i, q);
      auto stress = stress_at.middleRows<strain_count>(strain_count * static_cast<Eigen::Index>(q));
      stress.noalias() = weight_m3 * stress_per_strain * strains;
      strain_at.middleRows<strain_count>(strain_count * static_cast<Eigen::Index>(q)) = strains;
      pressure_at.row(q).noalias() = material.expansion_per_K * isotropic_strain.transpose() * stress;
    }
    cell_stiffness.noalias() = strain_at.transpose() * stress_at;
    cell_load.noalias() = pressure_at.transpose() * shape_at;
    const auto global = [&](int local) { return dim * static_cast<int>(dofs[local / dim]) + local % dim; };
    for (int i = 0; i < unknowns; ++i) {
      for (int j = 0; j < unknowns; ++j) stiffness.add(global(i), global(j), cell_stiffness(i, j));
      for (unsigned j = 0; j < per_cell; ++j) {
        thermal_load.add(global(i), static_cast<int>(dofs[j]), cell_load(i, j));
      }
    }
  }
  return {stiffness.take(), thermal_load.take()};
}

template VolumeTerms volume_terms<2>(const Discretisation<2>&, const Spindle&);
template ElasticTerms elastic_terms<2>(const Discretisation<2>&, const Spindle&);

}  // namespace spindle_twin::fem_offline
