#include "tests/rom/heat_quadrature.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace spindle_twin::rom::tests {

HeatQuadrature::HeatQuadrature(const Network& network)
    : network_(network), inverse_capacity_(network.capacity_J_per_K.inverse()) {
  Eigen::Index rank = 0;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[j];
    films_.push_back({factor * factor.colwise().sum().transpose(), network.boundaries.conductances[j].environment});
    rank = std::max(rank, factor.cols());
  }
  first_ = second_ = heat_W_ = Eigen::VectorXd::Zero(network.capacity_J_per_K.rows());
  through_ = Eigen::VectorXd::Zero(rank);
}

/// Heat of all films; inputs 0: of a rate, in which the held temperatures of the surroundings do not stand.
double HeatQuadrature::film_W(const BoundaryValues& values, const Eigen::VectorXd& nodes_K, double inputs) const {
  double sum_W = 0.0;
  for (std::size_t j = 0; j < films_.size(); ++j) {
    if (films_[j].environment < 0) continue;
    const double outside_K = inputs * values.environment_K[films_[j].environment];
    sum_W += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
             (films_[j].column.dot(nodes_K) - films_[j].column.sum() * outside_K);
  }
  return sum_W;
}

/// dT/dt; inputs 0: of a rate.
void HeatQuadrature::rate(const BoundaryValues& values, const Eigen::VectorXd& nodes_K, double inputs,
                          Eigen::VectorXd& to) {
  heat_W_.noalias() = network_.source_distribution * values.heat_W;
  if (values.node_heat_W.size() > 0) heat_W_ += values.node_heat_W;
  heat_W_ *= inputs;
  heat_W_.noalias() -= network_.conduction_W_per_K * nodes_K;
  for (std::size_t j = 0; j < films_.size(); ++j) {
    const Eigen::MatrixXd& factor = network_.factors_m[j];
    auto through = through_.head(factor.cols());
    through.noalias() = factor.transpose() * nodes_K;
    through *= values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
    heat_W_.noalias() -= factor * through;
    if (films_[j].environment < 0) continue;
    heat_W_ += inputs * values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
               values.environment_K[films_[j].environment] * films_[j].column;
  }
  to.noalias() = inverse_capacity_ * heat_W_;
  if (values.capacity_factor.size() > 0) to.array() /= values.capacity_factor.array();
}

HeatQuadrature::Instant HeatQuadrature::at(const BoundaryValues& values, const Eigen::VectorXd& nodes_K) {
  rate(values, nodes_K, 1.0, first_);
  rate(values, first_, 0.0, second_);
  return {film_W(values, nodes_K, 1.0), film_W(values, first_, 0.0), film_W(values, second_, 0.0)};
}

double HeatQuadrature::given_away_J(double period_s, const BoundaryValues& values, const Eigen::VectorXd& before_K,
                                    const Eigen::VectorXd& after_K) {
  const Instant from = at(values, before_K), to = at(values, after_K);
  const double h = period_s;
  return h / 2.0 * (from.heat_W + to.heat_W) + h * h / 10.0 * (from.rate_W_per_s - to.rate_W_per_s) +
         h * h * h / 120.0 * (from.curvature_W_per_s2 + to.curvature_W_per_s2);
}

}  // namespace spindle_twin::rom::tests
