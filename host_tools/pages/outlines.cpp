#include "host_tools/pages/outlines.hpp"

namespace spindle_twin::host_tools {

nlohmann::ordered_json outlines_json(const rom::Network& network) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const rom::OutlineRing& ring : network.outlines) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const auto& point : ring.points_m.colwise()) points.push_back({point[0], point[1]});
    list.push_back({{"part", ring.part}, {"points_m", points}});
  }
  return list;
}

}  // namespace spindle_twin::host_tools
