#include "fem_offline/look/field_file.hpp"

#include <deal.II/fe/fe_system.h>
#include <deal.II/numerics/data_out.h>

#include <fstream>

#include "rom/read/input_error.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double kelvin_at_0_degC = 273.15;

dealii::Vector<double> copied(const Eigen::VectorXd& values) {
  return dealii::Vector<double>(values.begin(), values.end());
}

/// The displacements in the numbering of a vector-valued element on the same mesh.
dealii::Vector<double> as_vector_field(const Discretisation<2>& discretisation,
                                       const dealii::DoFHandler<2>& vector_handler,
                                       const Eigen::VectorXd& displacements_m) {
  const auto& vector_element = vector_handler.get_fe();
  dealii::Vector<double> field(vector_handler.n_dofs());
  std::vector<dealii::types::global_dof_index> scalar_dofs(discretisation.element.n_dofs_per_cell());
  std::vector<dealii::types::global_dof_index> vector_dofs(vector_element.n_dofs_per_cell());
  auto vector_cell = vector_handler.begin_active();
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    cell->get_dof_indices(scalar_dofs);
    vector_cell->get_dof_indices(vector_dofs);
    for (unsigned i = 0; i < vector_dofs.size(); ++i) {
      const auto [component, base] = vector_element.system_to_component_index(i);
      field[vector_dofs[i]] = displacements_m[static_cast<Eigen::Index>(2 * scalar_dofs[base] + component)];
    }
    ++vector_cell;
  }
  return field;
}

}  // namespace

void write_field_file(const std::string& path, const Discretisation<2>& discretisation,
                      const Eigen::VectorXd& temperatures_K, const Eigen::VectorXd& rises_K,
                      const Eigen::VectorXd& displacements_m) {
  const dealii::FESystem<2> vector_element(discretisation.element, 2);
  dealii::DoFHandler<2> vector_handler(discretisation.triangulation);
  vector_handler.distribute_dofs(vector_element);
  const dealii::Vector<double> displacement = as_vector_field(discretisation, vector_handler, displacements_m);
  const dealii::Vector<double> temperature = copied(temperatures_K.array() - kelvin_at_0_degC);
  const dealii::Vector<double> rise = copied(rises_K);
  dealii::Vector<float> part(discretisation.triangulation.n_active_cells());
  for (const auto& cell : discretisation.triangulation.active_cell_iterators()) {
    part[cell->active_cell_index()] = static_cast<float>(cell->material_id());
  }

  dealii::DataOut<2> out;
  using Meaning = dealii::DataComponentInterpretation::DataComponentInterpretation;
  const std::vector<Meaning> vector_meaning(2, Meaning::component_is_part_of_vector);
  out.add_data_vector(discretisation.dof_handler, temperature, "temperature_degC");
  out.add_data_vector(discretisation.dof_handler, rise, "rise_K");
  out.add_data_vector(vector_handler, displacement, std::vector<std::string>(2, "displacement_m"), vector_meaning);
  out.attach_triangulation(discretisation.triangulation);
  out.add_data_vector(part, "part", dealii::DataOut<2>::type_cell_data);
  out.build_patches(discretisation.mapping, discretisation.element.degree);
  std::ofstream file(path);
  out.write_vtu(file);
  if (!file) throw rom::InputError({path, 0}, "", "cannot be written");
}

}  // namespace spindle_twin::fem_offline
