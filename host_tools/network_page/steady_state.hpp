#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "rom/integrate/heat_flows.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// A network that stood long enough at an operating state, nothing corrected.
struct SteadyState {
  const rom::Network& network;
  rom::OperatingState state;
  std::vector<rom::Body> bodies;  ///< parts and volumes of air; of a hand-written network its nodes
  rom::BoundaryValues values;
  std::shared_ptr<const rom::NetworkOperator> coordinates;
  Eigen::VectorXd temperatures_K;
  rom::HeatFlows flows;
};

/// Empty if nothing leads the heat to an environment. `network` must outlive the result.
std::optional<SteadyState> steady_state(const rom::Network& network, const rom::OperatingState& state);

/// `speed_rpm`, `load`, `rest_degC` (what rises are counted from), `key_points` (degC, rise in K), `deformations` (um),
/// and by the equations of rom/integrate/heat_flows.hpp and sensitivity.hpp: `balance` of every body, `flows` from body
/// to body or environment, `sensitivities` of the first deformation.
nlohmann::ordered_json steady_state_json(const SteadyState& steady);

}  // namespace spindle_twin::host_tools
