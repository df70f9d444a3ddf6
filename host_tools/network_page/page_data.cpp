#include "host_tools/network_page/page_data.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "correction/boundaries/schedule.hpp"
#include "host_tools/commands/inspection.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/heat_flows.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/integrate/sensitivity.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr Index shown_modes = 6;

struct Scene {
  const rom::Network& network;
  const rom::OperatingState& state;
  std::vector<rom::Body> bodies;
  rom::BoundaryValues values;
  std::shared_ptr<const rom::NetworkOperator> coordinates;
  Eigen::VectorXd temperatures_K;
  rom::HeatFlows flows;
};

/// Squared factor entries of a term, gathered per body: what of its area each body has.
Eigen::VectorXd area_shares(const Scene& scene, std::size_t term) {
  const Eigen::MatrixXd& factor = scene.network.factors_m[term];
  Eigen::VectorXd shares(static_cast<Index>(scene.bodies.size()));
  for (Index a = 0; a < shares.size(); ++a) {
    const auto& nodes = scene.bodies[static_cast<std::size_t>(a)].nodes;
    shares[a] = factor(nodes, Eigen::all).colwise().sum().squaredNorm();
  }
  return shares;
}

/// Where on the section a term acts: the mean place of the nodes of two bodies, by the squares of their factors.
Json place_of(const Scene& scene, std::size_t term, const std::vector<Index>& bodies) {
  const Eigen::MatrixXd& factor = scene.network.factors_m[term];
  double weight = 0.0, r_m = 0.0, z_m = 0.0;
  for (const Index body : bodies) {
    for (const Index i : scene.bodies[static_cast<std::size_t>(body)].nodes) {
      const double share = factor.row(i).squaredNorm();
      const rom::Node& node = scene.network.nodes[static_cast<std::size_t>(i)];
      weight += share, r_m += share * node.r_m, z_m += share * node.z_m;
    }
  }
  return weight > 0.0 ? Json{r_m / weight, z_m / weight} : Json();
}

/// Every exchange as flows from body to body or surroundings. Where more than two bodies take part one of them is the
/// hub: an air volume, which has all the area of the others.
Json flows_json(const Scene& scene) {
  const rom::Boundaries& boundaries = scene.network.boundaries;
  Json list = Json::array();
  for (std::size_t j = 0; j < scene.network.factors_m.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    const Eigen::VectorXd heat_W = scene.flows.exchange_W.col(static_cast<Index>(j));
    const Eigen::VectorXd shares = area_shares(scene, j);
    std::vector<Index> taking_part;
    for (Index a = 0; a < shares.size(); ++a) {
      if (shares[a] > 1e-9 * shares.maxCoeff()) taking_part.push_back(a);
    }
    const auto add = [&](Index from, const std::string& to, bool outside, const std::vector<Index>& at) {
      list.push_back({{"name", conductance.name},
                      {"kind", kind_name(conductance.kind)},
                      {"from", scene.bodies[static_cast<std::size_t>(from)].name},
                      {"to", to},
                      {"outside", outside},
                      {"heat_W", heat_W[from]},
                      {"at_m", place_of(scene, j, at)}});
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
      add(a, scene.bodies[static_cast<std::size_t>(hub)].name, false, at);
    }
  }
  return list;
}

/// Per body: sources, then what it loses to bodies, air, coolant, ambient; what is left.
Json balance_json(const Scene& scene) {
  const rom::Boundaries& boundaries = scene.network.boundaries;
  Json rows = Json::array();
  for (std::size_t a = 0; a < scene.bodies.size(); ++a) {
    const auto row = static_cast<Index>(a);
    double contact_W = 0.0, gas_W = 0.0, coolant_W = 0.0, ambient_W = 0.0;
    for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
      const rom::Conductance& conductance = boundaries.conductances[j];
      const double heat_W = scene.flows.exchange_W(row, static_cast<Index>(j));
      if (conductance.environment >= 0) {
        const auto environment = static_cast<std::size_t>(conductance.environment);
        (boundaries.environments[environment].kind == rom::EnvironmentKind::coolant ? coolant_W : ambient_W) += heat_W;
      } else {
        (conductance.kind == rom::ConductanceKind::contact ? contact_W : gas_W) += heat_W;
      }
    }
    double sum_K = 0.0;
    for (const Index i : scene.bodies[a].nodes) sum_K += scene.temperatures_K[i];
    double mean_K = sum_K / static_cast<double>(scene.bodies[a].nodes.size());
    for (const rom::PartOutput& part : scene.network.parts) {
      if (part.name == scene.bodies[a].name) mean_K = part.mean_row.dot(scene.temperatures_K);
    }
    rows.push_back({{"name", scene.bodies[a].name},
                    {"mean_degC", mean_K - kelvin_at_0_degC},
                    {"source_W", scene.flows.source_W.row(row).sum()},
                    {"contact_W", contact_W},
                    {"gas_W", gas_W},
                    {"coolant_W", coolant_W},
                    {"ambient_W", ambient_W},
                    {"conduction_W", scene.flows.conduction_W[row]},
                    {"left_W", scene.flows.stored_W[row]}});
  }
  return rows;
}

Json sensitivities_json(const Scene& scene) {
  const rom::Boundaries& boundaries = scene.network.boundaries;
  const double to_um_per_doubling = micrometres_per_metre * std::log(2.0);
  Json list = Json::array();
  if (scene.network.deformations.empty()) return list;
  const rom::SteadySensitivities found = rom::steady_sensitivities(
      scene.coordinates, scene.values, scene.temperatures_K, scene.network.deformations.front().row_m_per_K);
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    list.push_back({{"name", boundaries.conductances[j].name},
                    {"kind", kind_name(boundaries.conductances[j].kind)},
                    {"um_per_doubling", to_um_per_doubling * found.conductance[static_cast<Index>(j)]}});
  }
  return list;
}

/// Time constants with the share of a mode's heat content (v_i (C v)_i) that lies in each body.
Json modes_json(const Scene& scene) {
  const Index n = scene.coordinates->nodes();
  Eigen::VectorXd packed = scene.coordinates->make_packed();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  scene.coordinates->assemble(scene.values.conductance_W_per_m2K, packed, lower);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(lower);
  Json list = Json::array();
  for (Index m = 0; m < std::min(shown_modes, n); ++m) {
    const double rate_per_s = modes.eigenvalues()[m];
    const Eigen::VectorXd shape = scene.coordinates->capacity_root().transpose().triangularView<Eigen::Upper>().solve(
        modes.eigenvectors().col(m));
    const Eigen::VectorXd content = shape.cwiseProduct(scene.network.capacity_J_per_K * shape);
    std::vector<std::pair<double, std::string>> shares;
    for (const rom::Body& body : scene.bodies) shares.emplace_back(content(body.nodes).sum(), body.name);
    std::sort(shares.rbegin(), shares.rend());
    Json where = Json::array();
    for (std::size_t i = 0; i < std::min<std::size_t>(3, shares.size()); ++i) {
      where.push_back({{"name", shares[i].second}, {"share", shares[i].first}});
    }
    list.push_back({{"time_constant_s", rate_per_s > 0.0 ? 1.0 / rate_per_s : 0.0}, {"where", where}});
  }
  return list;
}

Json certificate_json(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  Json json{{"cases", certificate.cases}, {"seed", certificate.seed}, {"outputs", Json::array()}};
  const auto add = [&](const std::string& name, const char* unit, const rom::OutputError& error, double scale) {
    json["outputs"].push_back({{"name", name},
                               {"unit", unit},
                               {"worst", scale * error.worst},
                               {"median", scale * error.median},
                               {"mesh", scale * error.mesh}});
  };
  const auto each = [&](const auto& items, const auto& errors, const char* suffix, const char* unit, double scale) {
    if (errors.size() != items.size()) return;
    for (std::size_t i = 0; i < items.size(); ++i) add(items[i].name + suffix, unit, errors[i], scale);
  };
  each(network.deformations, certificate.deformations_m, "", "µm", micrometres_per_metre);
  each(network.key_points, certificate.key_points_K, "", "K", 1.0);
  each(network.parts, certificate.part_maxima_K, ", maximum", "K", 1.0);
  each(network.contact_pressures, certificate.contact_pressures_Pa, "", "MPa", megapascal_per_pascal);
  if (json["outputs"].empty() && certificate.cases > 0) {
    const auto& [worst, median] = std::pair(certificate.worst, certificate.median);
    add("deformation", "µm", {worst.nose_um, median.nose_um, 0.0}, 1.0);
    add("key points", "K", {worst.key_points_K, median.key_points_K, 0.0}, 1.0);
    add("part maxima", "K", {worst.part_max_K, median.part_max_K, 0.0}, 1.0);
  }
  return json;
}

Json places_json(const Scene& scene, double rest_K) {
  Json json{{"nodes", Json::array()}, {"outlines", Json::array()}, {"key_points", Json::array()}};
  for (std::size_t i = 0; i < scene.network.nodes.size(); ++i) {
    const rom::Node& node = scene.network.nodes[i];
    json["nodes"].push_back({{"name", node.name},
                             {"part", node.part},
                             {"at_m", {node.r_m, node.z_m}},
                             {"rise_K", scene.temperatures_K[static_cast<Index>(i)] - rest_K}});
  }
  for (const rom::OutlineRing& ring : scene.network.outlines) {
    Json points = Json::array();
    for (const auto& point : ring.points_m.colwise()) points.push_back({point[0], point[1]});
    json["outlines"].push_back({{"part", ring.part}, {"points_m", points}});
  }
  for (const rom::KeyPoint& point : scene.network.key_points) {
    json["key_points"].push_back({{"name", point.name},
                                  {"at_m", {point.r_m, point.z_m}},
                                  {"rise_K", point.row.dot(scene.temperatures_K) - rest_K}});
  }
  return json;
}

}  // namespace

Json network_page_data(const rom::Network& network, const rom::OperatingState& state, const std::string& file) {
  const rom::Boundaries& boundaries = network.boundaries;
  Scene scene{network,
              state,
              rom::network_bodies(network),
              correction::make_boundary_values(boundaries),
              std::make_shared<const rom::NetworkOperator>(network),
              {},
              {}};
  correction::evaluate_boundaries(boundaries, state, correction::no_correction(boundaries), scene.values);
  scene.temperatures_K = rom::steady_temperatures_K(scene.coordinates, scene.values);
  if (!scene.temperatures_K.allFinite() || scene.temperatures_K.cwiseAbs().maxCoeff() > 1e6) {
    throw rom::InputError({file, 0}, "--html", "no steady state: nothing leads the heat to an environment");
  }
  scene.flows = rom::heat_flows(network, scene.bodies, scene.values, scene.temperatures_K);
  const double rest_K = correction::rest_temperature_K(boundaries, state);

  Json data{
      {"spindle", network.spindle},   {"description_sha256", network.description_hash}, {"speed_rpm", state.speed_rpm},
      {"load", state.load},           {"rest_degC", rest_K - kelvin_at_0_degC},         {"environments", Json::array()},
      {"deformations", Json::array()}};
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    data["environments"].push_back({{"name", boundaries.environments[e].name},
                                    {"kind", kind_name(boundaries.environments[e].kind)},
                                    {"degC", state.environment_K[static_cast<Index>(e)] - kelvin_at_0_degC}});
  }
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::evaluate_outputs(network, scene.temperatures_K, outputs);
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    data["deformations"].push_back({{"name", network.deformations[d].name},
                                    {"um", micrometres_per_metre * outputs.deformations_m[static_cast<Index>(d)]}});
  }
  data["sources"] = Json::array();
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    data["sources"].push_back(
        {{"name", boundaries.sources[i].name}, {"heat_W", scene.values.heat_W[static_cast<Index>(i)]}});
  }
  data.update(places_json(scene, rest_K));
  data["flows"] = flows_json(scene);
  data["balance"] = balance_json(scene);
  data["sensitivities"] = sensitivities_json(scene);
  data["modes"] = modes_json(scene);
  data["certificate"] = certificate_json(network);
  return data;
}

}  // namespace spindle_twin::host_tools
