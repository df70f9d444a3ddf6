#pragma once

#include <string>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// Writes outputs.json of a CalculiX deck, numbers of nodes from 1: nodes of each part; key points and deformations as
/// [node, weight] sums (of a deformation also the output that comes off it, `minus`); steps of the transient; and for
/// the balance of every fluid its prescribed temperature, its flow and the sides that it wets.
void write_calculix_outputs(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                            const FluidHistory& history, const std::string& directory);

}  // namespace spindle_twin::fem_offline
