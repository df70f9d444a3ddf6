#include "fem_offline/model/field_error.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

#include <cmath>

namespace spindle_twin::fem_offline {

FieldError field_error(const Discretisation<2>& discretisation, const Eigen::VectorXd& nodal, const ExactField& exact) {
  const auto& element = discretisation.element;
  dealii::FEValues<2> values(
      discretisation.mapping, element, dealii::QGauss<2>(element.degree + 3),
      dealii::update_values | dealii::update_gradients | dealii::update_JxW_values | dealii::update_quadrature_points);
  std::vector<dealii::types::global_dof_index> dofs(element.n_dofs_per_cell());
  double value_error = 0.0, value_norm = 0.0, gradient_error = 0.0, gradient_norm = 0.0;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    cell->get_dof_indices(dofs);
    for (const unsigned q : values.quadrature_point_indices()) {
      const auto& place = values.quadrature_point(q);
      const Point at{place[0], place[1]};
      const double weight_m3 = values.JxW(q) * revolution_factor<2>(discretisation.geometry, place);
      double value = 0.0;
      dealii::Tensor<1, 2> gradient;
      for (unsigned i = 0; i < dofs.size(); ++i) {
        const double nodal_value = nodal[static_cast<Eigen::Index>(dofs[i])];
        value += nodal_value * values.shape_value(i, q);
        gradient += nodal_value * values.shape_grad(i, q);
      }
      const double exact_value = exact.value(at);
      const std::array<double, 2> exact_gradient = exact.gradient(at);
      value_error += weight_m3 * (value - exact_value) * (value - exact_value);
      value_norm += weight_m3 * exact_value * exact_value;
      for (unsigned c = 0; c < 2; ++c) {
        gradient_error += weight_m3 * (gradient[c] - exact_gradient[c]) * (gradient[c] - exact_gradient[c]);
        gradient_norm += weight_m3 * exact_gradient[c] * exact_gradient[c];
      }
    }
  }
  return {std::sqrt(value_error / value_norm), std::sqrt(gradient_error / gradient_norm)};
}

}  // namespace spindle_twin::fem_offline
