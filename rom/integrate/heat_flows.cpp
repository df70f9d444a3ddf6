#include "rom/integrate/heat_flows.hpp"

#include "rom/integrate/flow_rows.hpp"

namespace spindle_twin::rom {
namespace {

/// Squared factor entries of a term, gathered per body: what of its area each body has.
Eigen::VectorXd area_shares(const Network& network, const std::vector<Body>& bodies, std::size_t term) {
  const Eigen::MatrixXd& factor = network.factors_m[term];
  Eigen::VectorXd shares(static_cast<Eigen::Index>(bodies.size()));
  for (Eigen::Index a = 0; a < shares.size(); ++a) {
    const auto& nodes = bodies[static_cast<std::size_t>(a)].nodes;
    shares[a] = factor(nodes, Eigen::all).colwise().sum().squaredNorm();
  }
  return shares;
}

/// The mean place of the nodes of these bodies, by the squares of their factors.
void set_place(const Network& network, const std::vector<Body>& bodies, const std::vector<Eigen::Index>& at,
               FlowPath& path) {
  const Eigen::MatrixXd& factor = network.factors_m[static_cast<std::size_t>(path.conductance)];
  double weight = 0.0, r_m = 0.0, z_m = 0.0;
  for (const Eigen::Index body : at) {
    for (const Eigen::Index i : bodies[static_cast<std::size_t>(body)].nodes) {
      const double share = factor.row(i).squaredNorm();
      const Node& node = network.nodes[static_cast<std::size_t>(i)];
      weight += share, r_m += share * node.r_m, z_m += share * node.z_m;
    }
  }
  path.has_place = weight > 0.0;
  if (path.has_place) path.r_m = r_m / weight, path.z_m = z_m / weight;
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

std::vector<FlowPath> flow_paths(const Network& network, const std::vector<Body>& bodies) {
  std::vector<FlowPath> paths;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::VectorXd shares = area_shares(network, bodies, j);
    std::vector<Eigen::Index> taking_part;
    for (Eigen::Index a = 0; a < shares.size(); ++a) {
      if (shares[a] > 1e-9 * shares.maxCoeff()) taking_part.push_back(a);
    }
    const auto add = [&](Eigen::Index from, Eigen::Index to, const std::vector<Eigen::Index>& at) {
      FlowPath& path = paths.emplace_back();
      path.conductance = static_cast<Eigen::Index>(j);
      path.from = from;
      path.to = to;
      set_place(network, bodies, at, path);
    };
    if (network.boundaries.conductances[j].environment >= 0) {
      for (const Eigen::Index a : taking_part) add(a, -1, {a});
      continue;
    }
    Eigen::Index hub = 0;
    shares.maxCoeff(&hub);
    if (taking_part.size() == 2) hub = taking_part[1];
    for (const Eigen::Index a : taking_part) {
      if (a != hub) add(a, hub, taking_part.size() == 2 ? taking_part : std::vector<Eigen::Index>{a});
    }
  }
  return paths;
}

HeatFlows heat_flows(const Network& network, const std::vector<Body>& bodies, const BoundaryValues& values,
                     const Eigen::VectorXd& temperatures_K) {
  const auto count = static_cast<Eigen::Index>(bodies.size());
  const auto terms = static_cast<Eigen::Index>(network.factors_m.size());
  // Rises: a uniform temperature drives nothing, and differences of rises lose fewer digits than of kelvins.
  const double datum_K = network.boundaries.reference_temperature_K;
  const Eigen::VectorXd rises_K = temperatures_K.array() - datum_K;
  Eigen::VectorXd met_K(terms);
  MetTemperatures(network).evaluate(values, temperatures_K, met_K);
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
