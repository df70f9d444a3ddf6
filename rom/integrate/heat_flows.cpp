#include "rom/integrate/heat_flows.hpp"

#include <cmath>

#include "rom/integrate/coolant.hpp"

namespace spindle_twin::rom {
namespace {

/// Per conductance the temperature that its film meets; of the segments of circuits that of the liquid entering.
Eigen::VectorXd surroundings_K(const Network& network, const BoundaryValues& values,
                               const Eigen::VectorXd& temperatures_K) {
  const Boundaries& boundaries = network.boundaries;
  Eigen::VectorXd met_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.conductances.size()));
  for (Eigen::Index j = 0; j < met_K.size(); ++j) {
    const int environment = boundaries.conductances[static_cast<std::size_t>(j)].environment;
    if (environment >= 0) met_K[j] = values.environment_K[environment];
  }
  CoolantSegments segments = coolant_segments(boundaries);
  if (segments.count() == 0) return met_K;
  Eigen::VectorXd above_inlet_K(segments.count());
  for (Eigen::Index s = 0; s < segments.count(); ++s) {
    const auto j = static_cast<std::size_t>(segments.conductance[static_cast<std::size_t>(s)]);
    const Eigen::VectorXd sums_m = network.factors_m[j].colwise().sum().transpose();
    segments.area_m2[s] = sums_m.squaredNorm();
    const double wall_K = sums_m.dot(network.factors_m[j].transpose() * temperatures_K) / segments.area_m2[s];
    above_inlet_K[s] = wall_K - met_K[static_cast<Eigen::Index>(j)];
  }
  Eigen::MatrixXd upstream(segments.count(), segments.count());
  coolant_upstream(segments, values, upstream);
  const Eigen::VectorXd warmed_K = upstream * above_inlet_K;
  for (Eigen::Index s = 0; s < segments.count(); ++s) {
    met_K[segments.conductance[static_cast<std::size_t>(s)]] += warmed_K[s];
  }
  return met_K;
}

}  // namespace

std::vector<Body> network_bodies(const Network& network) {
  std::vector<Body> bodies;
  for (const PartOutput& part : network.parts) bodies.push_back({part.name, {}});
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    const Node& node = network.nodes[i];
    std::size_t body = 0;
    while (body < network.parts.size() && network.parts[body].name != node.part) ++body;
    if (body == network.parts.size()) {
      bodies.push_back({node.part.empty() ? node.name : node.part, {}});
      body = bodies.size() - 1;
    }
    bodies[body].nodes.push_back(static_cast<Eigen::Index>(i));
  }
  std::erase_if(bodies, [](const Body& body) { return body.nodes.empty(); });
  return bodies;
}

HeatFlows heat_flows(const Network& network, const std::vector<Body>& bodies, const BoundaryValues& values,
                     const Eigen::VectorXd& temperatures_K) {
  const auto count = static_cast<Eigen::Index>(bodies.size());
  const auto terms = static_cast<Eigen::Index>(network.factors_m.size());
  // Rises: a uniform temperature drives nothing, and differences of rises lose fewer digits than of kelvins.
  const double datum_K = network.boundaries.reference_temperature_K;
  const Eigen::VectorXd rises_K = temperatures_K.array() - datum_K;
  const Eigen::VectorXd met_K = surroundings_K(network, values, temperatures_K);
  const auto gathered = [&](const Eigen::VectorXd& per_node) {
    Eigen::VectorXd sums(count);
    for (Eigen::Index a = 0; a < count; ++a) sums[a] = per_node(bodies[static_cast<std::size_t>(a)].nodes).sum();
    return sums;
  };
  HeatFlows flows;
  flows.conduction_W = gathered(network.conduction_W_per_K * rises_K);
  flows.exchange_W.resize(count, terms);
  for (Eigen::Index j = 0; j < terms; ++j) {
    const auto term = static_cast<std::size_t>(j);
    const Eigen::MatrixXd& factor = network.factors_m[term];
    Eigen::VectorXd differences_K = factor.transpose() * rises_K;
    if (network.boundaries.conductances[term].environment >= 0) {
      differences_K -= (met_K[j] - datum_K) * factor.colwise().sum().transpose();
    }
    flows.exchange_W.col(j) = gathered(values.conductance_W_per_m2K[j] * (factor * differences_K));
  }
  flows.source_W.resize(count, network.source_distribution.cols());
  for (Eigen::Index i = 0; i < network.source_distribution.cols(); ++i) {
    flows.source_W.col(i) = gathered(values.heat_W[i] * network.source_distribution.col(i));
  }
  flows.node_W = Eigen::VectorXd::Zero(count);
  if (values.node_heat_W.size() > 0) flows.node_W = gathered(values.node_heat_W);
  flows.stored_W =
      flows.source_W.rowwise().sum() + flows.node_W - flows.conduction_W - flows.exchange_W.rowwise().sum();
  return flows;
}

}  // namespace spindle_twin::rom
