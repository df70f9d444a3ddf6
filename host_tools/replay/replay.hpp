#pragma once

#include <functional>

#include <string>
#include <vector>

#include "firmware/cycle/integrate.hpp"
#include "firmware/cycle/plan.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "host_tools/replay/log.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// One cycle of a replay.
struct ReplayedCycle {
  double time_s = 0.0;  ///< in the log's time, when the cycle began
  double end_s = 0.0;   ///< one advance later: what the prediction is for
  const firmware::Snapshot& snapshot;
};

/// Runs the log through the daemon's own cycle at the instants that the log says: no thread, no device, no waiting, the
/// same bits every time. A plain log has cycles every plan.period_s from its first row to its last, each with the
/// newest readings; of a history each row is a cycle, with its missed periods, its orders and readings as old as they
/// were. A signal that the log has is taken from there whatever the plan says. Throws rom::InputError as
/// firmware::Cycle does.
void replay(const rom::Network& network, firmware::CyclePlan plan, const Log& log,
            const std::function<void(const ReplayedCycle&)>& on_cycle);

/// The same with another integrator than the daemon's: other settings, say.
void replay(const rom::Network& network, firmware::CyclePlan plan, const Log& log,
            const std::function<void(const ReplayedCycle&)>& on_cycle, const firmware::MakeStepper& make_stepper);

/// A row per cycle: firmware::history_row, then predicted minus measured at the instant of the reading for every key
/// point, empty where nothing was read.
std::string replay_header(const rom::Network& network);
std::string replay_row(const firmware::Snapshot& snapshot, const std::vector<double>& error_K);

}  // namespace spindle_twin::host_tools
