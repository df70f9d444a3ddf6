#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Index of a surrounding among the environments of model and network, which leave out air volumes; -1 for those.
int environment_of(const Spindle& spindle, std::size_t surrounding) {
  int index = 0;
  for (std::size_t s = 0; s < surrounding; ++s) index += spindle.surroundings[s].kind != SurroundingKind::air;
  return spindle.surroundings[surrounding].kind == SurroundingKind::air ? -1 : index;
}

rom::OperatingState operating_of(const Spindle& spindle) {
  rom::OperatingState state;
  state.speed_rpm = spindle.operating.speed_rpm;
  state.load = spindle.operating.load;
  std::vector<double> environment_K;
  for (std::size_t s = 0; s < spindle.surroundings.size(); ++s) {
    if (spindle.surroundings[s].kind != SurroundingKind::air)
      environment_K.push_back(spindle.operating.surrounding_K[s]);
  }
  state.environment_K =
      Eigen::Map<const Eigen::VectorXd>(environment_K.data(), static_cast<Eigen::Index>(environment_K.size()));
  state.flow_kg_per_s.resize(static_cast<Eigen::Index>(spindle.circuits.size()));
  for (std::size_t c = 0; c < spindle.circuits.size(); ++c) {
    state.flow_kg_per_s[static_cast<Eigen::Index>(c)] = spindle.circuits[c].flow_kg_per_s;
  }
  return state;
}

}  // namespace

rom::PendingLaw law_of_film(const TomlTable& law, const Film& film, std::size_t film_index, const Spindle& spindle) {
  const int wall = film.only_parts.size() == 1 ? static_cast<int>(film.only_parts.front()) : -1;
  return {law,
          rom::LawRole::conductance,
          spindle.contacts.size() + film_index,
          {wall, -1, environment_of(spindle, film.surrounding)}};
}

void read_laws(const std::vector<rom::PendingLaw>& laws, Spindle& spindle) {
  if (laws.empty()) return;
  rom::LawPlaces places;
  for (const Part& part : spindle.parts) places.parts.push_back(part.name);
  for (const Surrounding& surrounding : spindle.surroundings) {
    if (surrounding.kind != SurroundingKind::air) places.environments.push_back(surrounding.name);
  }
  for (const auto& output : spindle.contact_pressures) places.contact_pressures.push_back(output.name);
  for (const DeformationOutput& output : spindle.deformations) places.deformations.push_back(output.name);
  const rom::OperatingState operating = operating_of(spindle);
  for (const rom::PendingLaw& pending : laws) {
    const rom::BoundLaw law = rom::read_physical_law(pending, places, spindle.operating.reference_temperature_K);
    const double nominal = rom::nominal_value(pending.table, law, operating);
    if (pending.role == rom::LawRole::heat) {
      spindle.heats[pending.index].heat_W = nominal;
      spindle.heats[pending.index].physics = law;
      continue;
    }
    std::size_t index = pending.index;
    if (index < spindle.contacts.size()) {
      spindle.contacts[index].conductance_W_per_m2K = nominal;
      spindle.contacts[index].physics = law;
      continue;
    }
    index -= spindle.contacts.size();
    if (index < spindle.films.size()) {
      spindle.films[index].coefficient_W_per_m2K = nominal;
      spindle.films[index].physics = law;
      continue;
    }
    index -= spindle.films.size();
    spindle.gap_films[index].coefficient_W_per_m2K = nominal;
    spindle.gap_films[index].physics = law;
  }
}

}  // namespace spindle_twin::fem_offline
