#include <Eigen/LU>
#include <cstdio>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

std::string node_name(const AffineModel& model, int unknown) {
  const DofPlace& place = model.places[static_cast<std::size_t>(unknown)];
  if (place.part < 0) {
    const std::size_t first_air = model.places.size() - model.air_names.size();
    return model.air_names[static_cast<std::size_t>(unknown) - first_air];
  }
  char text[64];
  std::snprintf(text, sizeof text, "@%.2f,%.2f", place.r_m * 1e3, place.z_m * 1e3);
  return model.parts[static_cast<std::size_t>(place.part)].name + text;
}

}  // namespace

void project_network(const AffineModel& model, const Eigen::MatrixXd& basis, int bodies, const NodalCoordinates& nodal,
                     int threads, rom::Network& network) {
  const Eigen::MatrixXd inverse = nodal.at_nodes.inverse();
  const auto at_nodes = [&](const Eigen::MatrixXd& term) {
    const Eigen::MatrixXd result = inverse.transpose() * term * inverse;
    return Eigen::MatrixXd(0.5 * (result + result.transpose()));
  };
  const int terms = static_cast<int>(model.conductance_terms_m2.size());
  network.factors_m.resize(model.conductance_terms_m2.size());
  for_each_index(terms + 2, threads, [&](int index, int) {
    if (index == 0) {
      network.capacity_J_per_K = at_nodes(project_term(model.capacity_J_per_K, basis));
      return;
    }
    // On the bodies' own columns conduction does nothing, and exchange between bodies nothing on the constant vector,
    // column 0: what stands there is rounding of the projection.
    if (index == 1) {
      Eigen::MatrixXd conduction = project_term(model.conduction_W_per_K, basis);
      conduction.topRows(bodies).setZero();
      conduction.leftCols(bodies).setZero();
      network.conduction_W_per_K = at_nodes(conduction);
      return;
    }
    const std::size_t j = static_cast<std::size_t>(index - 2);
    const bool exchange = model.boundaries.conductances[j].environment < 0;
    Eigen::MatrixXd orthonormal = project_term_factor(model.conductance_terms_m2[j], basis);
    if (exchange) orthonormal.row(0).setZero();
    Eigen::MatrixXd factor = inverse.transpose() * orthonormal;
    if (exchange) factor.rowwise() -= factor.colwise().mean().eval();
    network.factors_m[j] = factor;
  });
  for (int pass = 0; pass < 2; ++pass) {
    network.conduction_W_per_K.diagonal() -= network.conduction_W_per_K.rowwise().sum().eval();
  }

  network.source_distribution = nodal.interpolant.transpose() * model.source_distribution;
  const Eigen::RowVectorXd shortfall =
      Eigen::RowVectorXd::Ones(network.source_distribution.cols()) - network.source_distribution.colwise().sum();
  network.source_distribution.rowwise() += shortfall / static_cast<double>(basis.cols());
}

void project_outputs(const AffineModel& model, const NodalCoordinates& nodal, rom::Network& network) {
  const Eigen::MatrixXd& interpolant = nodal.interpolant;
  for (const int unknown : nodal.nodes) {
    const DofPlace& place = model.places[static_cast<std::size_t>(unknown)];
    const std::string part = place.part < 0 ? "" : model.parts[static_cast<std::size_t>(place.part)].name;
    network.nodes.push_back({node_name(model, unknown), part, place.r_m, place.z_m});
  }
  for (const FeKeyPoint& point : model.key_points) {
    const Eigen::VectorXd row = interpolant.transpose() * point.row;
    network.key_points.push_back(
        {point.name, model.parts[static_cast<std::size_t>(point.part)].name, point.at.r_m, point.at.z_m, row});
  }
  for (const FePart& part : model.parts) {
    network.parts.push_back({part.name, interpolant.transpose() * part.mean_row, Eigen::MatrixXd()});
  }
  for (const FeDeformation& deformation : model.deformations) {
    network.deformations.push_back({deformation.name, interpolant.transpose() * deformation.row_m_per_K});
  }
  for (const FeContactPressure& pressure : model.contact_pressures) {
    network.contact_pressures.push_back(
        {pressure.name, pressure.assembly_pressure_Pa, interpolant.transpose() * pressure.row_Pa_per_K});
  }
}

}  // namespace spindle_twin::fem_offline
