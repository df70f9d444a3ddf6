#include "host_tools/network_page/warm_up.hpp"

#include <algorithm>
#include <cmath>

#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int steps = 240;
constexpr double longest_s = 30.0 * 86400.0;

Json names_with(const auto& items, const char* values) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back({{"name", item.name}, {values, Json::array()}});
  return list;
}

}  // namespace

Json warm_up_json(const rom::Network& network, const rom::OperatingState& state, double time_constant_s,
                  const std::string& file) {
  const double period_s = std::max(1.0, std::ceil(std::min(5.0 * time_constant_s, longest_s) / steps));
  const double rest_K = rom::rest_temperature_K(network.boundaries, state);
  rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  const auto stepper = rom::make_runtime_stepper(network);
  stepper->set_temperatures(Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), rest_K));

  Json run{{"time_s", Json::array()},
           {"key_points", names_with(network.key_points, "rises_K")},
           {"deformations", names_with(network.deformations, "um")}};
  for (int step = 0; step <= steps; ++step) {
    if (step > 0 && stepper->advance(period_s, values) != rom::StepStatus::ok) {
      throw rom::InputError({file, 0}, "--html", "the warm-up of this network cannot be integrated");
    }
    rom::evaluate_outputs(network, stepper->temperatures_K(), outputs);
    run["time_s"].push_back(step * period_s);
    for (std::size_t k = 0; k < network.key_points.size(); ++k) {
      run["key_points"][k]["rises_K"].push_back(outputs.key_points_K[static_cast<Eigen::Index>(k)] - rest_K);
    }
    for (std::size_t d = 0; d < network.deformations.size(); ++d) {
      run["deformations"][d]["um"].push_back(rom::um_per_m * outputs.deformations_m[static_cast<Eigen::Index>(d)]);
    }
  }
  return run;
}

}  // namespace spindle_twin::host_tools
