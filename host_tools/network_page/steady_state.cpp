#include "host_tools/network_page/steady_state.hpp"

#include <cmath>

#include "host_tools/inspection/inspection.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/integrate/sensitivity.hpp"
#include "rom/kind_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;
using Json = nlohmann::ordered_json;

/// Every exchange as flows from body to body or surroundings.
Json flows_json(const SteadyState& steady) {
  const rom::Boundaries& boundaries = steady.network.boundaries;
  const auto body = [&](Index a) { return steady.bodies[static_cast<std::size_t>(a)].name; };
  Json list = Json::array();
  for (const rom::FlowPath& path : rom::flow_paths(steady.network, steady.bodies)) {
    const rom::Conductance& conductance = boundaries.conductances[static_cast<std::size_t>(path.conductance)];
    const bool outside = path.to < 0;
    list.push_back({{"name", conductance.name},
                    {"kind", kind_name(conductance.kind)},
                    {"from", body(path.from)},
                    {"to", outside ? boundaries.environments[static_cast<std::size_t>(conductance.environment)].name
                                   : body(path.to)},
                    {"outside", outside},
                    {"heat_W", steady.flows.exchange_W(path.from, path.conductance)},
                    {"at_m", path.has_place ? Json{path.r_m, path.z_m} : Json()}});
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
