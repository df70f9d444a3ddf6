#include "firmware/show/flow_json.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <span>

namespace spindle_twin::firmware {
namespace {

std::string listed(std::span<const double> values) {
  std::string json;
  for (const double value : values) {
    json.append(json.empty() ? "" : ",").append(std::isfinite(value) ? fmt::format("{:.3f}", value) : "null");
  }
  return json;
}

}  // namespace

std::string flows_json(const Snapshot& snapshot) {
  return fmt::format("\"heat\":{{\"flow_W\":[{}],\"made_W\":[{}]}}",
                     listed(std::span(snapshot.flow_W).first(snapshot.flows)),
                     listed(std::span(snapshot.made_W).first(snapshot.bodies)));
}

}  // namespace spindle_twin::firmware
