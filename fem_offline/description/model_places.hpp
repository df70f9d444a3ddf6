#pragma once

#include <cstddef>

#include "fem_offline/description/spindle.hpp"
#include "rom/boundaries.hpp"

/// Where the things of a description stand in the model and the network made of it: the only place that knows.
namespace spindle_twin::fem_offline {

// Order of conductances: contacts, gap films, films, each as in the description. Needs a spindle that is read whole.
inline std::size_t conductance_of_contact(const Spindle& /*spindle*/, std::size_t contact) { return contact; }
inline std::size_t conductance_of_gap_film(const Spindle& spindle, std::size_t gap_film) {
  return spindle.contacts.size() + gap_film;
}
inline std::size_t conductance_of_film(const Spindle& spindle, std::size_t film) {
  return conductance_of_gap_film(spindle, spindle.gap_films.size()) + film;
}

/// The line of the table that conductance `index` of the network comes from.
rom::SourceLine where_of_conductance(const Spindle& spindle, std::size_t index);

/// Place of a surrounding among the environments, which leave out air volumes; -1 for those.
int environment_of(const Spindle& spindle, std::size_t surrounding);

/// The description's operating state as the network has it: environments in their order, flows of the circuits.
rom::OperatingState operating_state(const Spindle& spindle);

}  // namespace spindle_twin::fem_offline
