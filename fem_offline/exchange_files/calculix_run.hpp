#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// CalculiX steps backwards in time, first order: the step must be short beside the fastest change that counts.
struct TimeStage {
  double until_s;
  double step_s;
};

/// One per output time of the plan, with longer steps as the changes slow down; every stage holds an even number.
std::vector<TimeStage> time_stages(const DeckPlan& plan);

/// Writes the shell script `run` of a CalculiX deck: all analyses in their order. CalculiX steps in time with first
/// order; the script combines two runs, twice the solution minus the one with doubled steps, to second order.
void write_calculix_run(std::size_t nodes, bool with_growth, const std::string& directory);

}  // namespace spindle_twin::fem_offline
