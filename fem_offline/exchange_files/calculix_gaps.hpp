#pragma once

#include <array>
#include <vector>

#include "fem_offline/exchange_files/deck_files.hpp"
#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// The nodes from `first` on as CalculiX numbers them, from 1. [m]
void write_nodes(DeckFile& file, const std::vector<Point>& nodes, std::size_t first);

/// One line of an *ELEMENT block.
void write_element(DeckFile& file, std::size_t number, const std::array<std::size_t, 8>& nodes);

/// Gap films as layers of elements between the two faces, numbered after those of the parts, nodes likewise. They
/// conduct across only, k = h r_m ln(r2/r1), so that the heat counts at the mean radius r_m, and store nothing.
/// Throws rom::InputError for a gap whose meshes do not match or that is neither along r nor along z.
void write_gap_layers(DeckFile& file, const Spindle& spindle, const DeckModel& deck);

}  // namespace spindle_twin::fem_offline
