#include "firmware/show/scene_json.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "firmware/cycle/heat_paths.hpp"
#include "firmware/show/json_text.hpp"
#include "rom/kind_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

template <class Things, class Text>
std::string listed(const Things& things, Text text) {
  std::string all;
  for (const auto& thing : things) {
    if (!all.empty()) all += ',';
    all += text(thing);
  }
  return all;
}

std::string place(double r_m, double z_m) { return fmt::format("[{},{}]", r_m, z_m); }

std::string outline(const rom::OutlineRing& ring) {
  std::string points;
  for (Eigen::Index i = 0; i < ring.points_m.cols(); ++i) {
    points.append(i > 0 ? "," : "").append(place(ring.points_m(0, i), ring.points_m(1, i)));
  }
  return fmt::format("{{\"part\":{},\"points_m\":[{}]}}", json_text(ring.part), points);
}

std::string key_point(const rom::KeyPoint& point) {
  return fmt::format("{{\"name\":{},\"at_m\":{}}}", json_text(point.name), place(point.r_m, point.z_m));
}

/// A body with the mean place of its nodes.
std::string body_json(const rom::Network& network, const rom::Body& body) {
  double r_m = 0.0, z_m = 0.0;
  for (const Eigen::Index i : body.nodes) {
    r_m += network.nodes[static_cast<std::size_t>(i)].r_m;
    z_m += network.nodes[static_cast<std::size_t>(i)].z_m;
  }
  const auto count = static_cast<double>(body.nodes.size());
  return fmt::format("{{\"name\":{},\"centre_m\":{}}}", json_text(body.name), place(r_m / count, z_m / count));
}

std::string flow_json(const rom::Network& network, const ToldFlows& told, const rom::FlowPath& path) {
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::Conductance& conductance = boundaries.conductances[static_cast<std::size_t>(path.conductance)];
  const bool is_outside = path.to < 0;
  const std::string& to = is_outside ? boundaries.environments[static_cast<std::size_t>(conductance.environment)].name
                                     : told.bodies[static_cast<std::size_t>(path.to)].name;
  return fmt::format("{{\"name\":{},\"kind\":{},\"from\":{},\"to\":{},\"outside\":{},\"at_m\":{}}}",
                     json_text(conductance.name), json_text(kind_name(conductance.kind)),
                     json_text(told.bodies[static_cast<std::size_t>(path.from)].name), json_text(to), is_outside,
                     path.has_place ? place(path.r_m, path.z_m) : "null");
}

std::string of_network(const rom::Network& network, const std::string& sha256) {
  const rom::Certificate& certificate = network.certificate;
  return fmt::format("{{\"sha256\":{},\"cases\":{},\"worst_K\":{},\"worst_nose_um\":{}}}", json_text(sha256),
                     certificate.cases, certificate.worst.key_points_K, certificate.worst.nose_um);
}

std::string of_compensation(const CompensationPlan& plan) {
  using rom::um_per_m;
  const std::string limit = std::isfinite(plan.limit_m) ? fmt::format("{}", um_per_m * plan.limit_m) : "null";
  return fmt::format("{{\"sign\":{},\"limit_um\":{},\"slew_um_per_s\":{},\"step_um\":{}}}", plan.sign, limit,
                     um_per_m * plan.slew_m_per_s, um_per_m * plan.step_m);
}

}  // namespace

std::string scene_json(const rom::Network& network, const SceneSettings& settings) {
  const ToldFlows told = told_flows(network);
  return fmt::format(
      "{{\"notice\":{},\"has_history\":{},\"outlines\":[{}],\"key_points\":[{}],"
      "\"deformations\":[{}],\"bodies\":[{}],\"flows\":[{}],\"network\":{},\"compensation\":{}}}",
      json_text(settings.notice), settings.has_history, listed(network.outlines, outline),
      listed(network.key_points, key_point),
      listed(network.deformations, [](const auto& each) { return json_text(each.name); }),
      listed(told.bodies, [&](const rom::Body& body) { return body_json(network, body); }),
      listed(told.paths, [&](const rom::FlowPath& path) { return flow_json(network, told, path); }),
      of_network(network, settings.network_sha256), of_compensation(settings.compensation));
}

}  // namespace spindle_twin::firmware
