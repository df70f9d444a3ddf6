#pragma once

#include <map>
#include <string>
#include <utility>

#include "fem_offline/exchange_files/deck_files.hpp"
#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// What a FreeFEM script is written from.
struct FreefemDeck {
  const Spindle& spindle;
  const DeckModel& model;
  const DeckPlan& plan;
};

/// Row and column to the name of a matrix, vector or number of the script. Unknowns: parts, then fluids.
using Blocks = std::map<std::pair<std::size_t, std::size_t>, std::string>;

/// Mesh, space V, conduction and films K, capacity C and heat Q of one part.
void write_part_terms(DeckFile& file, const FreefemDeck& deck, std::size_t part);

/// Contacts, gaps and fluids between the unknowns; returns the blocks of the conduction matrix. Faces whose nodes match
/// are integrated across the two meshes; others on a strip that both fields are interpolated to, which is exact.
Blocks write_coupling(DeckFile& file, const FreefemDeck& deck);

/// In the script's `report`: temperature of a fluid and the heat that it gets from the walls. [degC, W]
void write_fluid_report(DeckFile& file, const FreefemDeck& deck, std::size_t fluid);

}  // namespace spindle_twin::fem_offline
