#pragma once

#include <string>
#include <vector>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// Writes the meshes of a FreeFEM deck: part_N.msh per part, every quadrilateral split into two triangles; bonded.msh
/// of all parts, nodes of matching contacts merged (only with growth); two strips per pair of faces that does not
/// match. Border labels are numbers of pieces plus 1, regions are numbers of parts plus 1.
void write_freefem_meshes(const Spindle& spindle, const DeckModel& deck, const std::string& directory);

/// Name of the strip along the first or second face of a pair, without its ending.
std::string strip_name(std::size_t pair, bool first);

/// Pieces of a part that lie in the box, by their index in Section::pieces.
std::vector<std::size_t> pieces_in(const DeckModel& deck, std::size_t part, const Box& face);

/// How the second face of a pair is reached from the first: along the normal, by (r, z). [m]
Point offset_of(const DeckModel& deck, const DeckPair& pair);

}  // namespace spindle_twin::fem_offline
