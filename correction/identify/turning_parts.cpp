#include "correction/identify/turning_parts.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "correction/estimator/parameters.hpp"
#include "correction/identify/identify.hpp"

namespace spindle_twin::correction {
namespace {

int part_at(const rom::Network& network, const std::string& name) {
  const auto found = std::find_if(network.parts.begin(), network.parts.end(),
                                  [&](const rom::PartOutput& part) { return part.name == name; });
  return found == network.parts.end() ? -1 : static_cast<int>(found - network.parts.begin());
}

/// Parts that take most of a friction heat.
std::vector<bool> rolling_parts(const rom::Network& network, const std::vector<int>& part_of_node) {
  const ParameterModel parameters(network, constant_priors());
  std::vector<bool> rolling(network.parts.size(), false);
  for (Eigen::Index source = 0; source < network.source_distribution.cols(); ++source) {
    if (!parameters.is_friction(source)) continue;
    std::vector<double> taken(network.parts.size(), 0.0);
    for (std::size_t node = 0; node < part_of_node.size(); ++node) {
      if (part_of_node[node] < 0) continue;
      taken[static_cast<std::size_t>(part_of_node[node])] +=
          network.source_distribution(static_cast<Eigen::Index>(node), source);
    }
    if (!taken.empty())
      rolling[static_cast<std::size_t>(std::max_element(taken.begin(), taken.end()) - taken.begin())] = true;
  }
  return rolling;
}

/// Pairs of parts that touch.
std::vector<std::pair<int, int>> joints(const rom::Network& network, const std::vector<int>& part_of_node) {
  std::vector<std::pair<int, int>> pairs;
  for (const rom::Conductance& conductance : network.boundaries.conductances) {
    if (conductance.kind == rom::ConductanceKind::contact) pairs.emplace_back(conductance.part_a, conductance.part_b);
  }
  if (!network.hand_written) return pairs;
  for (std::size_t a = 0; a < part_of_node.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double joined = network.conduction_W_per_K(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      if (joined != 0.0) pairs.emplace_back(part_of_node[a], part_of_node[b]);
    }
  }
  return pairs;
}

}  // namespace

std::vector<std::string> turning_parts(const rom::Network& network) {
  std::vector<int> part_of_node;
  int innermost = -1, outermost = -1;
  double least_m = std::numeric_limits<double>::infinity(), most_m = -least_m;
  for (const rom::Node& node : network.nodes) {
    part_of_node.push_back(part_at(network, node.part));
    if (part_of_node.back() < 0) continue;
    if (node.r_m < least_m) innermost = part_of_node.back();
    if (node.r_m > most_m) outermost = part_of_node.back();
    least_m = std::min(least_m, node.r_m);
    most_m = std::max(most_m, node.r_m);
  }
  std::vector<std::string> names;
  if (innermost < 0) return names;
  const std::vector<bool> rolling = rolling_parts(network, part_of_node);
  std::vector<bool> turning(rolling.size(), false);
  turning[static_cast<std::size_t>(innermost)] = true;
  const auto pairs = joints(network, part_of_node);
  for (bool grown = true; grown;) {
    grown = false;
    for (const auto& [a, b] : pairs) {
      if (a < 0 || b < 0 || rolling[static_cast<std::size_t>(a)] || rolling[static_cast<std::size_t>(b)]) continue;
      if (turning[static_cast<std::size_t>(a)] == turning[static_cast<std::size_t>(b)]) continue;
      turning[static_cast<std::size_t>(a)] = turning[static_cast<std::size_t>(b)] = grown = true;
    }
  }
  const bool shows = !turning[static_cast<std::size_t>(outermost)];
  for (std::size_t p = 0; p < turning.size(); ++p) {
    if (rolling[p] || (shows && turning[p])) names.push_back(network.parts[p].name);
  }
  return names;
}

}  // namespace spindle_twin::correction
