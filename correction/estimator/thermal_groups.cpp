#include "correction/estimator/thermal_groups.hpp"

#include <algorithm>
#include <limits>

namespace spindle_twin::correction {
namespace {

/// K₀ + Σ g F Fᵀ of what lies between bodies, at nominal conductances.
Eigen::MatrixXd exchange_of(const rom::Network& network) {
  Eigen::MatrixXd exchange = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const rom::Conductance& conductance = network.boundaries.conductances[j];
    if (conductance.environment >= 0) continue;
    exchange += conductance.nominal_W_per_m2K * network.factors_m[j] * network.factors_m[j].transpose();
  }
  return exchange;
}

std::vector<ThermalGroup> parts_of(const rom::Network& network) {
  std::vector<ThermalGroup> groups;
  std::vector<std::string> parts;
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const rom::Node& node = network.nodes[static_cast<std::size_t>(i)];
    const auto known = std::find(parts.begin(), parts.end(), node.part);
    const bool alone = node.part.empty() || network.hand_written;
    if (alone || known == parts.end()) {
      groups.push_back({alone ? node.name : node.part, Eigen::VectorXd::Zero(nodes), 0.0});
      parts.push_back(alone ? std::string{} : node.part);
      groups.back().indicator[i] = 1.0;
    } else {
      groups[static_cast<std::size_t>(known - parts.begin())].indicator[i] = 1.0;
    }
  }
  return groups;
}

}  // namespace

std::vector<ThermalGroup> thermal_groups(const rom::Network& network, std::size_t most) {
  std::vector<ThermalGroup> groups = parts_of(network);
  const Eigen::MatrixXd exchange = exchange_of(network);
  std::vector<double> largest(groups.size());  // capacity of the part that gives the name
  for (std::size_t a = 0; a < groups.size(); ++a) {
    ThermalGroup& group = groups[a];
    group.capacity_J_per_K = largest[a] = group.indicator.dot(network.capacity_J_per_K * group.indicator);
  }
  while (groups.size() > std::max<std::size_t>(most, 1)) {
    std::size_t first = 0, second = 1;
    double fastest = -std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < groups.size(); ++a) {
      const Eigen::VectorXd from = exchange * groups[a].indicator;
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        const double rate =
            -from.dot(groups[b].indicator) * (1.0 / groups[a].capacity_J_per_K + 1.0 / groups[b].capacity_J_per_K);
        if (rate <= fastest) continue;
        fastest = rate;
        first = a;
        second = b;
      }
    }
    if (largest[second] > largest[first]) {
      groups[first].name = groups[second].name;
      largest[first] = largest[second];
    }
    groups[first].indicator += groups[second].indicator;
    groups[first].capacity_J_per_K = groups[first].indicator.dot(network.capacity_J_per_K * groups[first].indicator);
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(second));
    largest.erase(largest.begin() + static_cast<std::ptrdiff_t>(second));
  }
  return groups;
}

}  // namespace spindle_twin::correction
