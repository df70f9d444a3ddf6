#include "fem_offline/description/face_conditions.hpp"
#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {

using rom::any_number;
using rom::positive;

namespace {

/// What all segments of a circuit have in common.
struct SharedFilm {
  std::optional<TomlTable> channel;             ///< the table `law`: of all segments
  std::optional<double> coefficient_W_per_m2K;  ///< of those that have none of their own
  rom::SpeedLaw law;
};

Film read_segment(const TomlTable& segment, const SharedFilm& shared, std::size_t inlet, Reading& into) {
  Film film;
  film.condition = &face_condition("coolant_circuit");
  film.name = into.films.add(segment);
  film.where = segment.where("name");
  film.surrounding = inlet;
  const auto own_W_per_m2K = segment.optional_number("coefficient_W_per_m2K", positive);
  if (shared.channel && own_W_per_m2K) {
    segment.fail("coefficient_W_per_m2K", "cannot stand beside the circuit's law, which gives the value");
  }
  if (!own_W_per_m2K && !shared.coefficient_W_per_m2K) {
    segment.fail("coefficient_W_per_m2K", "missing: give it to this segment or to its whole circuit");
  }
  film.coefficient_W_per_m2K = own_W_per_m2K ? *own_W_per_m2K : *shared.coefficient_W_per_m2K;
  film.regions = read_regions(segment);
  film.only_parts = into.parts.find_all(segment, "only_parts", segment.strings_or_empty("only_parts"));
  film.law = shared.law;
  return film;
}

}  // namespace

void read_coolant_circuit(const TomlTable& table, Reading& into) {
  Spindle& spindle = into.spindle;
  CoolantCircuit circuit;
  circuit.name = into.circuits.add(table);
  circuit.where = table.where("name");
  circuit.inlet = into.surroundings.find(table, "inlet");
  if (spindle.surroundings[circuit.inlet].kind != SurroundingKind::coolant) {
    table.fail("inlet", "must be a surrounding of kind coolant; \"" + spindle.surroundings[circuit.inlet].name +
                            "\" is of another kind");
  }
  circuit.flow_kg_per_s = table.number("flow_kg_per_s", any_number);
  circuit.heat_capacity_J_per_kgK = table.number("heat_capacity_J_per_kgK", positive);
  SharedFilm shared;
  shared.channel = rom::optional_law(table, {"coefficient_W_per_m2K", "speed_law"});
  shared.coefficient_W_per_m2K =
      shared.channel ? std::optional(0.0) : table.optional_number("coefficient_W_per_m2K", positive);
  if (!shared.channel) shared.law = read_speed_law(table);
  for (const auto& segment : table.tables("segments")) {
    Film film = read_segment(segment, shared, circuit.inlet, into);
    if (shared.channel) {
      rom::PendingLaw& pending =
          into.laws.emplace_back(law_of_film(*shared.channel, film, spindle.films.size(), spindle)).pending;
      pending.role = rom::LawRole::channel;
      pending.defaults.circuit = static_cast<int>(spindle.circuits.size());
    }
    circuit.segments.push_back(spindle.films.size());
    spindle.films.push_back(std::move(film));
  }
  spindle.circuits.push_back(std::move(circuit));
}

}  // namespace spindle_twin::fem_offline
