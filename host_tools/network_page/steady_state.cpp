#include "host_tools/network_page/steady_state.hpp"

#include <cmath>

#include "host_tools/inspection/inspection.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/integrate/sensitivity.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;
using Json = nlohmann::ordered_json;

/// Squared factor entries of a term, gathered per body: what of its area each body has.
Eigen::VectorXd area_shares(const SteadyState& steady, std::size_t term) {
  const Eigen::MatrixXd& factor = steady.network.factors_m[term];
  Eigen::VectorXd shares(static_cast<Index>(steady.bodies.size()));
  for (Index a = 0; a < shares.size(); ++a) {
    const auto& nodes = steady.bodies[static_cast<std::size_t>(a)].nodes;
    shares[a] = factor(nodes, Eigen::all).colwise().sum().squaredNorm();
  }
  return shares;
}

/// Where on the section a term acts: the mean place of the nodes of two bodies, by the squares of their factors.
Json place_of(const SteadyState& steady, std::size_t term, const std::vector<Index>& bodies) {
  const Eigen::MatrixXd& factor = steady.network.factors_m[term];
  double weight = 0.0, r_m = 0.0, z_m = 0.0;
  for (const Index body : bodies) {
    for (const Index i : steady.bodies[static_cast<std::size_t>(body)].nodes) {
      const double share = factor.row(i).squaredNorm();
      const rom::Node& node = steady.network.nodes[static_cast<std::size_t>(i)];
      weight += share, r_m += share * node.r_m, z_m += share * node.z_m;
    }
  }
  return weight > 0.0 ? Json{r_m / weight, z_m / weight} : Json();
}

/// Every exchange as flows from body to body or surroundings. Where more than two bodies take part one of them is the
/// hub: an air volume, which has all the area of the others.
Json flows_json(const SteadyState& steady) {
  const rom::Boundaries& boundaries = steady.network.boundaries;
  Json list = Json::array();
  for (std::size_t j = 0; j < steady.network.factors_m.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    const Eigen::VectorXd heat_W = steady.flows.exchange_W.col(static_cast<Index>(j));
    const Eigen::VectorXd shares = area_shares(steady, j);
    std::vector<Index> taking_part;
    for (Index a = 0; a < shares.size(); ++a) {
      if (shares[a] > 1e-9 * shares.maxCoeff()) taking_part.push_back(a);
    }
    const auto add = [&](Index from, const std::string& to, bool outside, const std::vector<Index>& at) {
      list.push_back({{"name", conductance.name},
                      {"kind", kind_name(conductance.kind)},
                      {"from", steady.bodies[static_cast<std::size_t>(from)].name},
                      {"to", to},
                      {"outside", outside},
                      {"heat_W", heat_W[from]},
                      {"at_m", place_of(steady, j, at)}});
    };
    if (conductance.environment >= 0) {
      const rom::Environment& environment = boundaries.environments[static_cast<std::size_t>(conductance.environment)];
      for (const Index a : taking_part) add(a, environment.name, true, {a});
      continue;
    }
    Index hub = 0;
    shares.maxCoeff(&hub);
    if (taking_part.size() == 2) hub = taking_part[1];
    for (const Index a : taking_part) {
      if (a == hub) continue;
      const std::vector<Index> at = taking_part.size() == 2 ? taking_part : std::vector<Index>{a};
      add(a, steady.bodies[static_cast<std::size_t>(hub)].name, false, at);
    }
  }
  return list;
}

/// Per body: sources, then what it loses to bodies, air, coolant, ambient; what is left.
Json balance_json(const SteadyState& steady) {
  const rom::Boundaries& boundaries = steady.network.boundaries;
  Json rows = Json::array();
  for (std::size_t a = 0; a < steady.bodies.size(); ++a) {
    const auto row = static_cast<Index>(a);
    double contact_W = 0.0, gas_W = 0.0, coolant_W = 0.0, ambient_W = 0.0;
    for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
      const rom::Conductance& conductance = boundaries.conductances[j];
      const double heat_W = steady.flows.exchange_W(row, static_cast<Index>(j));
      if (conductance.environment >= 0) {
        const auto environment = static_cast<std::size_t>(conductance.environment);
        (boundaries.environments[environment].kind == rom::EnvironmentKind::coolant ? coolant_W : ambient_W) += heat_W;
      } else {
        (conductance.kind == rom::ConductanceKind::contact ? contact_W : gas_W) += heat_W;
      }
    }
    double sum_K = 0.0;
    for (const Index i : steady.bodies[a].nodes) sum_K += steady.temperatures_K[i];
    double mean_K = sum_K / static_cast<double>(steady.bodies[a].nodes.size());
    for (const rom::PartOutput& part : steady.network.parts) {
      if (!steady.network.hand_written && part.name == steady.bodies[a].name)
        mean_K = part.mean_row.dot(steady.temperatures_K);
    }
    rows.push_back({{"name", steady.bodies[a].name},
                    {"mean_degC", mean_K - rom::zero_degC_K},
                    {"source_W", steady.flows.source_W.row(row).sum()},
                    {"contact_W", contact_W},
                    {"gas_W", gas_W},
                    {"coolant_W", coolant_W},
                    {"ambient_W", ambient_W},
                    {"conduction_W", steady.flows.conduction_W[row]},
                    {"residue_W", steady.flows.stored_W[row]}});
  }
  return rows;
}

Json sensitivities_json(const SteadyState& steady) {
  const rom::Boundaries& boundaries = steady.network.boundaries;
  const double to_um_per_doubling = rom::um_per_m * std::log(2.0);
  Json list = Json::array();
  if (steady.network.deformations.empty()) return list;
  const rom::SteadySensitivities found = rom::steady_sensitivities(
      steady.coordinates, steady.values, steady.temperatures_K, steady.network.deformations.front().row_m_per_K);
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    list.push_back({{"name", boundaries.conductances[j].name},
                    {"kind", kind_name(boundaries.conductances[j].kind)},
                    {"um_per_doubling", to_um_per_doubling * found.conductance[static_cast<Index>(j)]}});
  }
  return list;
}

/// What the network says of itself: temperatures of the key points, and how much longer the spindle is.
Json outputs_json(const SteadyState& steady, double rest_K) {
  const rom::Network& network = steady.network;
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::evaluate_outputs(network, steady.temperatures_K, outputs);
  Json json{{"key_points", Json::array()}, {"deformations", Json::array()}};
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    const double temperature_K = outputs.key_points_K[static_cast<Index>(k)];
    json["key_points"].push_back({{"name", network.key_points[k].name},
                                  {"degC", temperature_K - rom::zero_degC_K},
                                  {"rise_K", temperature_K - rest_K}});
  }
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    json["deformations"].push_back({{"name", network.deformations[d].name},
                                    {"um", rom::um_per_m * outputs.deformations_m[static_cast<Index>(d)]}});
  }
  return json;
}

/// A node that a person wrote is a lump of its own.
std::vector<rom::Body> bodies_of(const rom::Network& network) {
  if (!network.hand_written) return rom::network_bodies(network);
  std::vector<rom::Body> bodies;
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    bodies.push_back({network.nodes[i].name, {static_cast<Index>(i)}});
  }
  return bodies;
}

}  // namespace

std::optional<SteadyState> steady_state(const rom::Network& network, const rom::OperatingState& state) {
  const rom::Boundaries& boundaries = network.boundaries;
  SteadyState steady{network,
                     state,
                     bodies_of(network),
                     rom::make_boundary_values(boundaries),
                     std::make_shared<const rom::NetworkOperator>(network),
                     {},
                     {}};
  rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), steady.values);
  steady.temperatures_K = rom::steady_temperatures_K(steady.coordinates, steady.values);
  steady.coordinates->laws().at_temperatures(steady.temperatures_K, steady.values);
  if (!steady.temperatures_K.allFinite() || steady.temperatures_K.cwiseAbs().maxCoeff() > 1e6) return std::nullopt;
  steady.flows = rom::heat_flows(network, steady.bodies, steady.values, steady.temperatures_K);
  return steady;
}

Json steady_state_json(const SteadyState& steady) {
  const double rest_K = rom::rest_temperature_K(steady.network.boundaries, steady.state);
  Json json{{"speed_rpm", steady.state.speed_rpm},
            {"load", steady.state.load},
            {"rest_degC", rest_K - rom::zero_degC_K},
            {"balance", balance_json(steady)},
            {"flows", flows_json(steady)},
            {"sensitivities", sensitivities_json(steady)}};
  json.update(outputs_json(steady, rest_K));
  return json;
}

}  // namespace spindle_twin::host_tools
