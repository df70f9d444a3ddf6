#pragma once

#include <string>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// Writes bonds.inc of a CalculiX deck: what moves together, by equations, and what is held. Where the nodes of two
/// faces do not match, those of the finer one move as the parabolas through the nodes of the other.
void write_calculix_bonds(const DeckModel& deck, const std::string& directory);

}  // namespace spindle_twin::fem_offline
