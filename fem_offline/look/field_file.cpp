#include "fem_offline/look/field_file.hpp"

#include <deal.II/fe/fe_system.h>
#include <deal.II/numerics/data_out.h>
#include <deal.II/numerics/data_postprocessor.h>

#include <array>
#include <fstream>
#include <utility>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/stress.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

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

using StressFields = std::vector<std::pair<std::string, dealii::Vector<double>>>;

StressFields stress_fields(const Eigen::MatrixXd& stresses_Pa) {
  StressFields fields;
  if (stresses_Pa.rows() == 0) return fields;
  const std::array<const char*, 4> names = {"stress_rr_Pa", "stress_zz_Pa", "stress_tt_Pa", "stress_rz_Pa"};
  for (Eigen::Index c = 0; c < 4; ++c) fields.emplace_back(names[c], copied(stresses_Pa.col(c)));
  Eigen::VectorXd von_mises(stresses_Pa.rows());
  for (Eigen::Index i = 0; i < von_mises.size(); ++i) von_mises[i] = von_mises_Pa(stress_from(stresses_Pa.row(i)));
  fields.emplace_back("stress_von_mises_Pa", copied(von_mises));
  return fields;
}

/// −k ∇T with the conductivities of the element's part.
class HeatFlux : public dealii::DataPostprocessorVector<2> {
 public:
  explicit HeatFlux(const Spindle& spindle)
      : dealii::DataPostprocessorVector<2>("heat_flux_W_per_m2", dealii::update_gradients), spindle_(&spindle) {}

  void evaluate_scalar_field(const dealii::DataPostprocessorInputs::Scalar<2>& inputs,
                             std::vector<dealii::Vector<double>>& fluxes) const override {
    const Material& material = spindle_->materials[spindle_->parts[inputs.get_cell<2>()->material_id()].material];
    for (std::size_t q = 0; q < fluxes.size(); ++q) {
      fluxes[q][0] = -material.conductivity_r_W_per_mK * inputs.solution_gradients[q][0];
      fluxes[q][1] = -material.conductivity_z_W_per_mK * inputs.solution_gradients[q][1];
    }
  }

 private:
  const Spindle* spindle_;
};

}  // namespace

void write_field_file(const std::string& path, const FeModel& model, const Eigen::VectorXd& temperatures_K) {
  const Discretisation<2>& discretisation = model.discretisation();
  const Eigen::VectorXd at_nodes_K = temperatures_K.head(static_cast<Eigen::Index>(discretisation.places.size()));
  const Eigen::VectorXd rises_K = at_nodes_K.array() - model.affine().boundaries.reference_temperature_K;
  const dealii::FESystem<2> vector_element(discretisation.element, 2);
  dealii::DoFHandler<2> vector_handler(discretisation.triangulation);
  vector_handler.distribute_dofs(vector_element);
  const dealii::Vector<double> displacement =
      as_vector_field(discretisation, vector_handler, model.displacements_m(temperatures_K));
  const dealii::Vector<double> temperature = copied(at_nodes_K.array() - rom::zero_degC_K);
  const dealii::Vector<double> rise = copied(rises_K);
  dealii::Vector<float> part(discretisation.triangulation.n_active_cells());
  for (const auto& cell : discretisation.triangulation.active_cell_iterators()) {
    part[cell->active_cell_index()] = static_cast<float>(cell->material_id());
  }

  const StressFields stress = stress_fields(model.stresses_Pa(temperatures_K));

  const HeatFlux heat_flux(model.description());
  dealii::DataOut<2> out;
  using Meaning = dealii::DataComponentInterpretation::DataComponentInterpretation;
  const std::vector<Meaning> vector_meaning(2, Meaning::component_is_part_of_vector);
  out.add_data_vector(discretisation.dof_handler, temperature, "temperature_degC");
  out.add_data_vector(discretisation.dof_handler, rise, "rise_K");
  out.add_data_vector(discretisation.dof_handler, temperature, heat_flux);
  out.add_data_vector(vector_handler, displacement, std::vector<std::string>(2, "displacement_m"), vector_meaning);
  for (const auto& [name, values] : stress) out.add_data_vector(discretisation.dof_handler, values, name);
  out.attach_triangulation(discretisation.triangulation);
  out.add_data_vector(part, "part", dealii::DataOut<2>::type_cell_data);
  out.build_patches(discretisation.mapping, discretisation.element.degree);
  std::ofstream file(path);
  out.write_vtu(file);
  if (!file) throw rom::InputError({path, 0}, "", "cannot be written");
}

}  // namespace spindle_twin::fem_offline
