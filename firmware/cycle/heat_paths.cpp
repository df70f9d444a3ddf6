#include "firmware/cycle/heat_paths.hpp"

#include <algorithm>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::firmware {

ToldFlows told_flows(const rom::Network& network) {
  ToldFlows told{rom::network_bodies(network), {}};
  told.paths = rom::flow_paths(network, told.bodies);
  const auto room = static_cast<Eigen::Index>(slots::bodies);
  std::erase_if(told.paths, [&](const rom::FlowPath& path) { return path.from >= room || path.to >= room; });
  if (told.bodies.size() > slots::bodies) told.bodies.resize(slots::bodies);
  if (told.paths.size() > slots::flows) told.paths.resize(slots::flows);
  return told;
}

HeatPaths::HeatPaths(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> shared)
    : operator_(shared ? std::move(shared) : std::make_shared<const rom::NetworkOperator>(network)),
      rows_([&] {
        const ToldFlows told = told_flows(network);
        return rom::FlowRows(network, told.bodies, told.paths);
      }()),
      values_(rom::make_boundary_values(network.boundaries)),
      heat_W_(rows_.paths()),
      made_W_(rows_.bodies()) {}

void HeatPaths::publish(const Model& model, Snapshot& snapshot) {
  const Eigen::VectorXd& temperatures_K = model.stepper->temperatures_K();
  values_ = model.values;
  operator_->laws().at_temperatures(temperatures_K, values_);
  rows_.evaluate(values_, temperatures_K, heat_W_, made_W_);
  snapshot.flows = static_cast<std::size_t>(heat_W_.size());
  snapshot.bodies = static_cast<std::size_t>(made_W_.size());
  std::copy_n(heat_W_.data(), snapshot.flows, snapshot.flow_W.begin());
  std::copy_n(made_W_.data(), snapshot.bodies, snapshot.made_W.begin());
}

}  // namespace spindle_twin::firmware
