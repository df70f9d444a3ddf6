#pragma once

#include <memory>
#include <vector>

#include "firmware/cycle/integrate.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "rom/integrate/flow_rows.hpp"

namespace spindle_twin::firmware {

/// Which heat flows of a network are told, and between which bodies (parts, volumes of air): the first ones where there
/// is no room for all (states.toml).
struct ToldFlows {
  std::vector<rom::Body> bodies;
  std::vector<rom::FlowPath> paths;
};

/// Allocates.
ToldFlows told_flows(const rom::Network& network);

/// Heat from part to part, into films, coolant and ambient, as the corrected model has it.
class HeatPaths {
 public:
  /// shared: the operator of that network; null: one of its own. Allocates.
  HeatPaths(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> shared);

  /// At the model's present state, into the snapshot. Runs in the cycle, no allocation after the first call.
  void publish(const Model& model, Snapshot& snapshot);

 private:
  std::shared_ptr<const rom::NetworkOperator> operator_;
  rom::FlowRows rows_;
  rom::BoundaryValues values_;
  Eigen::VectorXd heat_W_, made_W_;
};

}  // namespace spindle_twin::firmware
