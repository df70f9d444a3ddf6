#pragma once

#include <string>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// Writes a complete CalculiX deck into the folder: steady.inp, transient.inp, growth_*.inp (if the deck
/// carries deformations), the files they include, outputs.json (which nodes with which weights make each output) and a
/// README. Elements CAX8; contacts as tied contact with gap conductance; a gap film as a layer of elements that
/// conducts across only, k = h r_m ln(r2/r1), so that the heat counts at the mean radius r_m; temperatures in degC,
/// those of air and of the liquid in coolant circuits prescribed. Throws rom::InputError for a gap whose meshes do not
/// match or that is neither along r nor along z.
void write_calculix_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                         const FluidHistory& history, const std::string& directory);

}  // namespace spindle_twin::fem_offline
