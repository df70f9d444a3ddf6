#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cstdio>

#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Below this share of the largest eigenvalue a projected term holds rounding only.
constexpr double rank_tolerance = 1e-14;

/// F with FFᵀ = term, smallest rank that rounding allows.
Eigen::MatrixXd symmetric_factor(const Eigen::MatrixXd& term) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(term);
  const Eigen::VectorXd& values = modes.eigenvalues();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[values.size() - 1 - rank] > rank_tolerance * values[values.size() - 1]) ++rank;
  return modes.eigenvectors().rightCols(rank) * values.tail(rank).cwiseSqrt().asDiagonal();
}

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

void project_network(const RichModel& rich, const Eigen::MatrixXd& coordinates, const AffineModel& model,
                     const NodalCoordinates& nodal, int threads, rom::Network& network) {
  const Eigen::Index count = coordinates.cols();
  const Eigen::MatrixXd inverse = nodal.at_nodes.inverse();
  const auto symmetric = [](const Eigen::MatrixXd& a) { return Eigen::MatrixXd(0.5 * (a + a.transpose())); };
  const auto orthonormal = [&](const Eigen::MatrixXd& term) {
    return symmetric(coordinates.transpose() * (term * coordinates));
  };

  network.capacity_J_per_K = symmetric(inverse.transpose() * orthonormal(rich.dense.capacity) * inverse);

  // On the bodies' own columns conduction does nothing, and exchange between bodies nothing on the constant vector,
  // coordinate 0: what stands there is rounding of the projection.
  Eigen::MatrixXd conduction = orthonormal(rich.dense.conduction);
  conduction.topRows(rich.bodies).setZero();
  conduction.leftCols(rich.bodies).setZero();
  network.conduction_W_per_K = symmetric(inverse.transpose() * conduction * inverse);
  for (int pass = 0; pass < 2; ++pass) {
    network.conduction_W_per_K.diagonal() -= network.conduction_W_per_K.rowwise().sum().eval();
  }

  network.factors_m.resize(rich.dense.conductance_terms.size());
  for_each_index(static_cast<int>(rich.dense.conductance_terms.size()), threads, [&](int index, int) {
    const std::size_t j = static_cast<std::size_t>(index);
    const bool exchange = model.boundaries.conductances[j].environment < 0;
    Eigen::MatrixXd term = orthonormal(rich.dense.conductance_terms[j].whole());
    if (exchange) {
      term.row(0).setZero();
      term.col(0).setZero();
    }
    Eigen::MatrixXd factor = inverse.transpose() * symmetric_factor(term);
    if (exchange) factor.rowwise() -= factor.colwise().mean().eval();
    network.factors_m[j] = factor;
  });

  network.source_distribution = nodal.interpolant.transpose() * model.source_distribution;
  const Eigen::RowVectorXd shortfall =
      Eigen::RowVectorXd::Ones(network.source_distribution.cols()) - network.source_distribution.colwise().sum();
  network.source_distribution.rowwise() += shortfall / static_cast<double>(count);
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
