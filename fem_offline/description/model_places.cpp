#include "fem_offline/description/model_places.hpp"

#include <vector>

namespace spindle_twin::fem_offline {

rom::SourceLine where_of_conductance(const Spindle& spindle, std::size_t index) {
  const std::size_t first_gap = conductance_of_gap_film(spindle, 0), first_film = conductance_of_film(spindle, 0);
  if (index < first_gap) return spindle.contacts[index].where;
  if (index < first_film) return spindle.gap_films[index - first_gap].where;
  return spindle.films.at(index - first_film).where;
}

int environment_of(const Spindle& spindle, std::size_t surrounding) {
  int index = 0;
  for (std::size_t s = 0; s < surrounding; ++s) index += spindle.surroundings[s].kind != SurroundingKind::air;
  return spindle.surroundings[surrounding].kind == SurroundingKind::air ? -1 : index;
}

rom::OperatingState operating_state(const Spindle& spindle) {
  rom::OperatingState state;
  state.speed_rpm = spindle.operating.speed_rpm;
  state.load = spindle.operating.load;
  std::vector<double> environment_K;
  for (std::size_t s = 0; s < spindle.surroundings.size(); ++s) {
    if (spindle.surroundings[s].kind != SurroundingKind::air) {
      environment_K.push_back(spindle.operating.surrounding_K.at(s));
    }
  }
  state.environment_K =
      Eigen::Map<const Eigen::VectorXd>(environment_K.data(), static_cast<Eigen::Index>(environment_K.size()));
  state.flow_kg_per_s.resize(static_cast<Eigen::Index>(spindle.circuits.size()));
  for (std::size_t c = 0; c < spindle.circuits.size(); ++c) {
    state.flow_kg_per_s[static_cast<Eigen::Index>(c)] = spindle.circuits[c].flow_kg_per_s;
  }
  return state;
}

}  // namespace spindle_twin::fem_offline
