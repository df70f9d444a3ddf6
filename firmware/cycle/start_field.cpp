#include "firmware/cycle/start_field.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace spindle_twin::firmware {
namespace {

/// Heat conduction between the nodes, and springs of heat to what is known.
struct Balance {
  Eigen::MatrixXd matrix_W_per_K;
  Eigen::VectorXd right_W;

  void pull(const Eigen::VectorXd& row, double to_K, double stiffness_W_per_K) {
    matrix_W_per_K += stiffness_W_per_K * row * row.transpose();
    right_W += stiffness_W_per_K * to_K * row;
  }
};

Balance between_nodes(const rom::Network& network) {
  Balance balance{network.conduction_W_per_K, Eigen::VectorXd::Zero(network.conduction_W_per_K.rows())};
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const rom::Conductance& conductance = network.boundaries.conductances[j];
    if (conductance.environment >= 0) continue;
    const Eigen::MatrixXd& factor_m = network.factors_m[j];
    balance.matrix_W_per_K += conductance.nominal_W_per_m2K * factor_m * factor_m.transpose();
  }
  return balance;
}

}  // namespace

Eigen::VectorXd start_field(const rom::Network& network, const Snapshot& said) {
  double sum_K = 0.0;
  double known = 0.0;
  const std::size_t points = std::min(said.key_points, network.key_points.size());
  for (std::size_t k = 0; k < points; ++k) {
    if (!std::isfinite(said.predicted_K[k])) continue;
    sum_K += said.predicted_K[k];
    known += 1.0;
  }
  if (known == 0.0) return {};
  const double mean_K = sum_K / known;  // temperatures count from here: what nothing connects has it

  Balance balance = between_nodes(network);
  const double scale_W_per_K = std::max(balance.matrix_W_per_K.diagonal().maxCoeff(), 1.0);
  constexpr double of_key_point = 1e5;  // against the stiffest node
  constexpr double of_part = 10.0;
  constexpr double of_loose_node = 1e-9;
  for (std::size_t k = 0; k < points; ++k) {
    if (!std::isfinite(said.predicted_K[k])) continue;
    balance.pull(network.key_points[k].row, said.predicted_K[k] - mean_K, of_key_point * scale_W_per_K);
  }
  for (std::size_t p = 0; p < std::min(said.parts, network.parts.size()); ++p) {
    if (!std::isfinite(said.part_maximum_K[p])) continue;
    balance.pull(network.parts[p].mean_row, said.part_maximum_K[p] - mean_K, of_part * scale_W_per_K);
  }
  balance.matrix_W_per_K.diagonal().array() += of_loose_node * scale_W_per_K;
  return balance.matrix_W_per_K.ldlt().solve(balance.right_W).array() + mean_K;
}

}  // namespace spindle_twin::firmware
