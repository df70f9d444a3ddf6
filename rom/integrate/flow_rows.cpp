#include "rom/integrate/flow_rows.hpp"

namespace spindle_twin::rom {

MetTemperatures::MetTemperatures(const Network& network)
    : segments_(coolant_segments(network.boundaries)),
      walls_(network.capacity_J_per_K.rows(), segments_.count()),
      upstream_(segments_.count(), segments_.count()),
      above_inlet_K_(segments_.count()),
      warmed_K_(segments_.count()) {
  for (const Conductance& conductance : network.boundaries.conductances) {
    environment_.push_back(conductance.environment);
  }
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    const auto j = static_cast<std::size_t>(segments_.conductance[static_cast<std::size_t>(s)]);
    const Eigen::VectorXd sums_m = network.factors_m[j].colwise().sum().transpose();
    segments_.area_m2[s] = sums_m.squaredNorm();
    walls_.col(s) = network.factors_m[j] * sums_m / segments_.area_m2[s];
  }
}

void MetTemperatures::evaluate(const BoundaryValues& values, const Eigen::VectorXd& temperatures_K,
                               Eigen::VectorXd& met_K) {
  for (std::size_t j = 0; j < environment_.size(); ++j) {
    met_K[static_cast<Eigen::Index>(j)] = environment_[j] < 0 ? 0.0 : values.environment_K[environment_[j]];
  }
  if (segments_.count() == 0) return;
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    above_inlet_K_[s] = walls_.col(s).dot(temperatures_K) - met_K[segments_.conductance[static_cast<std::size_t>(s)]];
  }
  coolant_upstream(segments_, values, upstream_);
  warmed_K_.noalias() = upstream_ * above_inlet_K_;
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    met_K[segments_.conductance[static_cast<std::size_t>(s)]] += warmed_K_[s];
  }
}

FlowRows::FlowRows(const Network& network, const std::vector<Body>& bodies, const std::vector<FlowPath>& paths)
    : datum_K_(network.boundaries.reference_temperature_K),
      rows_m2_(static_cast<Eigen::Index>(paths.size()), network.capacity_J_per_K.rows()),
      to_environment_m2_(Eigen::VectorXd::Zero(rows_m2_.rows())),
      gather_(Rows::Zero(static_cast<Eigen::Index>(bodies.size()), rows_m2_.cols())),
      met_(network),
      rises_K_(rows_m2_.cols()),
      met_K_(static_cast<Eigen::Index>(network.factors_m.size())) {
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (const Eigen::Index i : bodies[a].nodes) gather_(static_cast<Eigen::Index>(a), i) = 1.0;
  }
  conduction_ = gather_ * network.conduction_W_per_K;
  sources_ = gather_ * network.source_distribution;
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const FlowPath& path = paths[p];
    const auto row = static_cast<Eigen::Index>(p);
    const Eigen::MatrixXd& factor = network.factors_m[static_cast<std::size_t>(path.conductance)];
    conductance_.push_back(path.conductance);
    rows_m2_.row(row).noalias() = (gather_.row(path.from) * factor) * factor.transpose();
    if (path.to < 0) to_environment_m2_[row] = rows_m2_.row(row).sum();
  }
}

void FlowRows::evaluate(const BoundaryValues& values, const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& heat_W,
                        Eigen::VectorXd& made_W) {
  // Rises: a uniform temperature drives nothing, and differences of rises lose fewer digits than of kelvins.
  rises_K_ = temperatures_K.array() - datum_K_;
  met_.evaluate(values, temperatures_K, met_K_);
  heat_W.noalias() = rows_m2_ * rises_K_;
  for (Eigen::Index p = 0; p < paths(); ++p) {
    const Eigen::Index j = conductance_[static_cast<std::size_t>(p)];
    heat_W[p] -= to_environment_m2_[p] * (met_K_[j] - datum_K_);
    heat_W[p] *= values.conductance_W_per_m2K[j];
  }
  made_W.noalias() = sources_ * values.heat_W;
  made_W.noalias() -= conduction_ * rises_K_;
  if (values.node_heat_W.size() > 0) made_W.noalias() += gather_ * values.node_heat_W;
}

}  // namespace spindle_twin::rom
