#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {

using rom::any_number;
using rom::positive;

void read_coolant_circuits(const TomlTable& root, const Names& parts, const Names& surroundings, Names& films,
                           Spindle& spindle, std::vector<DescribedLaw>& laws) {
  Names circuits("coolant circuit");
  for (const auto& table : root.tables_or_empty("coolant_circuit")) {
    CoolantCircuit circuit;
    circuit.name = circuits.add(table);
    circuit.where = table.where("name");
    circuit.inlet = surroundings.find(table, "inlet");
    if (spindle.surroundings[circuit.inlet].kind != SurroundingKind::coolant) {
      table.fail("inlet", "must be a surrounding of kind coolant; \"" + spindle.surroundings[circuit.inlet].name +
                              "\" is of another kind");
    }
    circuit.flow_kg_per_s = table.number("flow_kg_per_s", any_number);
    circuit.heat_capacity_J_per_kgK = table.number("heat_capacity_J_per_kgK", positive);
    const auto channel = rom::optional_law(table, {"coefficient_W_per_m2K", "speed_law"});
    const auto shared_W_per_m2K =
        channel ? std::optional(0.0) : table.optional_number("coefficient_W_per_m2K", positive);
    const rom::SpeedLaw law = channel ? rom::SpeedLaw{} : read_speed_law(table);
    for (const auto& segment : table.tables("segments")) {
      Film film;
      film.name = films.add(segment);
      film.where = segment.where("name");
      film.surrounding = circuit.inlet;
      const auto own_W_per_m2K = segment.optional_number("coefficient_W_per_m2K", positive);
      if (channel && own_W_per_m2K) {
        segment.fail("coefficient_W_per_m2K", "cannot stand beside the circuit's law, which gives the value");
      }
      if (!own_W_per_m2K && !shared_W_per_m2K) {
        segment.fail("coefficient_W_per_m2K", "missing: give it to this segment or to its whole circuit");
      }
      film.coefficient_W_per_m2K = own_W_per_m2K ? *own_W_per_m2K : *shared_W_per_m2K;
      film.regions = read_regions(segment);
      film.only_parts = parts.find_all(segment, "only_parts", segment.strings_or_empty("only_parts"));
      film.law = law;
      circuit.segments.push_back(spindle.films.size());
      if (channel) {
        laws.push_back(law_of_film(*channel, film, spindle.films.size(), spindle));
        laws.back().pending.role = rom::LawRole::channel;
        laws.back().pending.defaults.circuit = static_cast<int>(spindle.circuits.size());
      }
      spindle.films.push_back(std::move(film));
    }
    spindle.circuits.push_back(std::move(circuit));
  }
}

}  // namespace spindle_twin::fem_offline
