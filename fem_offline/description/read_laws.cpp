#include "fem_offline/description/model_places.hpp"
#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {
DescribedLaw law_of_film(const TomlTable& law, const Film& film, std::size_t film_index, const Spindle& spindle) {
  const int wall = film.only_parts.size() == 1 ? static_cast<int>(film.only_parts.front()) : -1;
  return {LawOwner::film,
          {law, rom::LawRole::conductance, film_index, {wall, -1, environment_of(spindle, film.surrounding)}}};
}

namespace {

/// The law becomes the `physics` of its owner and gives its nominal value.
void give_to_owner(LawOwner owner, std::size_t index, const rom::BoundLaw& law, double nominal, Spindle& spindle) {
  switch (owner) {
    case LawOwner::heat:
      spindle.heats[index].heat_W = nominal;
      spindle.heats[index].physics = law;
      break;
    case LawOwner::contact:
      spindle.contacts[index].conductance_W_per_m2K = nominal;
      spindle.contacts[index].physics = law;
      break;
    case LawOwner::gap_film:
      spindle.gap_films[index].coefficient_W_per_m2K = nominal;
      spindle.gap_films[index].physics = law;
      break;
    case LawOwner::film:
      spindle.films[index].coefficient_W_per_m2K = nominal;
      spindle.films[index].physics = law;
      break;
  }
}

}  // namespace

void read_laws(const std::vector<DescribedLaw>& laws, Spindle& spindle) {
  if (laws.empty()) return;
  rom::LawPlaces places;
  for (const Part& part : spindle.parts) places.parts.push_back(part.name);
  for (const Surrounding& surrounding : spindle.surroundings) {
    if (surrounding.kind != SurroundingKind::air) places.environments.push_back(surrounding.name);
  }
  for (const auto& output : spindle.contact_pressures) places.contact_pressures.push_back(output.name);
  for (const DeformationOutput& output : spindle.deformations) places.deformations.push_back(output.name);
  const rom::OperatingState operating = operating_state(spindle);
  for (const auto& [owner, pending] : laws) {
    const rom::BoundLaw law = rom::read_physical_law(pending, places, spindle.operating.reference_temperature_K);
    give_to_owner(owner, pending.index, law, rom::nominal_value(pending.table, law, operating), spindle);
  }
}

}  // namespace spindle_twin::fem_offline
