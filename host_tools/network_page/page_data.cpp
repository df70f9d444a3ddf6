#include "host_tools/network_page/page_data.hpp"

#include <fmt/core.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/inspection/inspection.hpp"
#include "host_tools/network_page/steady_state.hpp"
#include "host_tools/network_page/warm_up.hpp"
#include "host_tools/pages/outlines.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/kind_names.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Index = Eigen::Index;
using Json = nlohmann::ordered_json;

constexpr Index shown_modes = 6;

/// Time constants with the share of a mode's heat content (v_i (C v)_i) that lies in each body.
Json modes_json(const SteadyState& steady) {
  const Index n = steady.coordinates->nodes();
  Eigen::VectorXd packed = steady.coordinates->make_packed();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  steady.coordinates->assemble(steady.values.conductance_W_per_m2K, packed, lower);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(lower);
  Json list = Json::array();
  for (Index m = 0; m < std::min(shown_modes, n); ++m) {
    const double rate_per_s = modes.eigenvalues()[m];
    const Eigen::VectorXd shape = steady.coordinates->capacity_root().transpose().triangularView<Eigen::Upper>().solve(
        modes.eigenvectors().col(m));
    const Eigen::VectorXd content = shape.cwiseProduct(steady.network.capacity_J_per_K * shape);
    std::vector<std::pair<double, std::string>> shares;
    for (const rom::Body& body : steady.bodies) shares.emplace_back(content(body.nodes).sum(), body.name);
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
  if (certificate.limit_rule.content > 0.0) json["limit"] = limit_text(certificate.limit_rule);
  if (certificate.searched > 0) {
    const rom::CertificateErrors& found = certificate.worst_found;
    json["found"] = fmt::format("{:.4f} K at a key point, {:.4f} um, {:.4f} K of a part's maximum, of {} jumps",
                                found.key_points_K, found.nose_um, found.part_max_K, certificate.searched);
  }
  const auto add = [&](const std::string& name, const char* unit, const rom::OutputError& error, double scale) {
    json["outputs"].push_back({{"name", name},
                               {"unit", unit},
                               {"worst", scale * error.worst},
                               {"median", scale * error.median},
                               {"mesh", scale * error.mesh},
                               {"limit", scale * error.limit}});
  };
  const auto each = [&](const auto& items, const auto& errors, const char* suffix, const char* unit, double scale) {
    if (errors.size() != items.size()) return;
    for (std::size_t i = 0; i < items.size(); ++i) add(items[i].name + suffix, unit, errors[i], scale);
  };
  each(network.deformations, certificate.deformations_m, "", "µm", rom::um_per_m);
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

/// Nodes and outlines; the key points of the steady state get their places.
void add_places(const SteadyState& steady, double rest_K, Json& data) {
  data["nodes"] = Json::array();
  data["outlines"] = outlines_json(steady.network);
  for (std::size_t i = 0; i < steady.network.nodes.size(); ++i) {
    const rom::Node& node = steady.network.nodes[i];
    data["nodes"].push_back({{"name", node.name},
                             {"part", node.part},
                             {"at_m", {node.r_m, node.z_m}},
                             {"rise_K", steady.temperatures_K[static_cast<Index>(i)] - rest_K}});
  }
  for (std::size_t k = 0; k < steady.network.key_points.size(); ++k) {
    const rom::KeyPoint& point = steady.network.key_points[k];
    data["key_points"][k]["at_m"] = {point.r_m, point.z_m};
  }
}

}  // namespace

Json network_page_data(const rom::Network& network, const rom::OperatingState& state, const std::string& file) {
  const rom::Boundaries& boundaries = network.boundaries;
  const std::optional<SteadyState> found = steady_state(network, state);
  if (!found) {
    throw rom::InputError({file, 0}, "--html", "no steady state: nothing leads the heat to an environment");
  }
  const SteadyState& steady = *found;
  const double rest_K = rom::rest_temperature_K(boundaries, state);

  Json data{{"spindle", network.spindle},
            {"description_sha256", network.description_hash},
            {"hand_written", network.hand_written},
            {"environments", Json::array()}};
  data.update(steady_state_json(steady));
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    data["environments"].push_back({{"name", boundaries.environments[e].name},
                                    {"kind", kind_name(boundaries.environments[e].kind)},
                                    {"degC", state.environment_K[static_cast<Index>(e)] - rom::zero_degC_K}});
  }
  data["sources"] = Json::array();
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    data["sources"].push_back(
        {{"name", boundaries.sources[i].name}, {"heat_W", steady.values.heat_W[static_cast<Index>(i)]}});
  }
  add_places(steady, rest_K, data);
  data["modes"] = modes_json(steady);
  data["warm_up"] = warm_up_json(network, state, data["modes"][0]["time_constant_s"], file);
  data["certificate"] = certificate_json(network);
  return data;
}

}  // namespace spindle_twin::host_tools
