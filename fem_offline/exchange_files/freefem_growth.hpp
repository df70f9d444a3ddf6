#pragma once

#include "fem_offline/exchange_files/freefem_terms.hpp"

namespace spindle_twin::fem_offline {

/// Stiffness E and load of the bonded body. Nodes of matching contacts are one; the others are tied by springs along
/// the strips that write_coupling has read.
void write_elastic(DeckFile& file, const FreefemDeck& deck);

/// In the script's `report`: solves for the displacements and prints every deformation.
void write_growth_report(DeckFile& file, const FreefemDeck& deck);

}  // namespace spindle_twin::fem_offline
