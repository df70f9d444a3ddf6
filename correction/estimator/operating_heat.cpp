#include "correction/estimator/operating_heat.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {
namespace {

/// Σ over the nodes of the group and those outside of |E_ij (x_i − x_j)|.
double over_border_W(const Eigen::MatrixXd& between_W_per_K, const Eigen::VectorXd& rise_K,
                     const Eigen::VectorXd& indicator) {
  double flow_W = 0.0;
  for (Eigen::Index i = 0; i < rise_K.size(); ++i) {
    if (indicator[i] == 0.0) continue;
    for (Eigen::Index j = 0; j < rise_K.size(); ++j) {
      if (indicator[j] == 0.0) flow_W += std::abs(between_W_per_K(i, j) * (rise_K[i] - rise_K[j]));
    }
  }
  return flow_W;
}

}  // namespace

double nominal_heats_W(const rom::Network& network) {
  double heats_W = 0.0;
  for (const rom::HeatSource& source : network.boundaries.sources) heats_W += std::abs(source.nominal_W);
  return heats_W;
}

std::vector<double> heat_through_groups_W(const rom::Network& network, const std::vector<ThermalGroup>& groups) {
  rom::BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  Eigen::MatrixXd between = network.conduction_W_per_K, whole = between;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd conductance = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
                                        network.factors_m[j] * network.factors_m[j].transpose();
    whole += conductance;
    if (network.boundaries.conductances[j].environment < 0) between += conductance;
  }
  const Eigen::MatrixXd sources_W = network.source_distribution * values.heat_W.asDiagonal();
  const Eigen::VectorXd heat_W = sources_W.rowwise().sum();
  const Eigen::LLT<Eigen::MatrixXd> steady(whole);
  const Eigen::VectorXd rise_K = steady.solve(heat_W);
  if (steady.info() != Eigen::Success || !rise_K.allFinite()) {
    return std::vector<double>(groups.size(), values.heat_W.lpNorm<1>());
  }
  const Eigen::VectorXd lost_W = heat_W - between * rise_K;
  std::vector<double> through_W;
  through_W.reserve(groups.size());
  for (const ThermalGroup& group : groups) {
    through_W.push_back(0.5 *
                        ((group.indicator.transpose() * sources_W).lpNorm<1>() +
                         over_border_W(between, rise_K, group.indicator) + std::abs(group.indicator.dot(lost_W))));
  }
  return through_W;
}

}  // namespace spindle_twin::correction
