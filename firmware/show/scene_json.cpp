#include "firmware/show/scene_json.hpp"

#include <spdlog/fmt/fmt.h>

#include "firmware/show/json_text.hpp"

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

}  // namespace

std::string scene_json(const rom::Network& network, const std::string& notice, bool has_history) {
  return fmt::format(
      "{{\"notice\":{},\"has_history\":{},\"outlines\":[{}],\"key_points\":[{}],"
      "\"deformations\":[{}]}}",
      json_text(notice), has_history, listed(network.outlines, outline), listed(network.key_points, key_point),
      listed(network.deformations, [](const auto& each) { return json_text(each.name); }));
}

}  // namespace spindle_twin::firmware
