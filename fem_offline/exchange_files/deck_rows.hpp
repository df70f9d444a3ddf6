#pragma once

#include <cstddef>

#include "fem_offline/exchange_files/deck_model.hpp"

namespace spindle_twin::fem_offline {

/// A field of `part` at a point of it, or at the nearest one: the element functions of the nodes around, which sum
/// to 1.
DeckRow row_at(const DeckModel& deck, std::size_t part, const Point& at);

/// Mean of a field over the output's face, weighted by r, times the output's sign.
DeckRow mean_over(const DeckModel& deck, const DeformationOutput& output);

}  // namespace spindle_twin::fem_offline
