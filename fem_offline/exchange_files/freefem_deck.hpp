#pragma once

#include <string>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// Writes a complete FreeFEM deck into the folder: one mesh per part (every quadrilateral split into two triangles, P2:
/// the same unknowns as nine-node quadrilaterals), one mesh of all parts with bonded nodes merged, spindle.edp and a
/// README. Contacts and gaps integrate across the two meshes, or on a strip between them where nodes do not match;
/// volumes of air and the liquid of coolant circuits are unknowns of their own; the transient is BDF2 with a constant
/// step and one factor. Throws rom::InputError if a file cannot be written.
void write_freefem_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                        const std::string& directory);

}  // namespace spindle_twin::fem_offline
