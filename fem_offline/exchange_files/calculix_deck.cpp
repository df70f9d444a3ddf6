#include "fem_offline/exchange_files/calculix_deck.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "fem_offline/exchange_files/calculix_run.hpp"
#include "fem_offline/exchange_files/deck_files.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// CalculiX steps backwards in time, first order: the step must be short beside the fastest change that counts.
struct TimeStage {
  double until_s;
  double step_s;
};

/// Names of sets: P part, M material, B and A the sides of a pair, G gap, I contact, V air volume.
std::string name(char letter, std::size_t number) { return std::string(1, letter).append(std::to_string(number)); }

/// A gap's layer: elements between the two faces, nodes across numbered after those of the mesh.
struct GapLayer {
  std::size_t pair = 0;
  double conductivity_r_W_per_mK = 0.0;
  double conductivity_z_W_per_mK = 0.0;
  std::vector<std::array<std::size_t, 8>> elements;
};

/// Along the faces the layer must not conduct; a millionth keeps the material matrix regular.
constexpr double along_share = 1e-6;

GapLayer make_layer(const Spindle& spindle, const DeckModel& deck, std::size_t number, std::vector<Point>& nodes) {
  const DeckPair& pair = deck.pairs[number];
  const GapFilm& gap = spindle.gap_films[pair.index];
  if (!pair.matching) {
    throw rom::InputError(gap.where, gap.name, "the meshes of the two faces do not match, which CalculiX needs here");
  }
  const Point& a = deck.section.pieces[pair.piece_a].start;
  const Point& a_end = deck.section.pieces[pair.piece_a].end;
  const Point& b = deck.section.pieces[pair.piece_b].start;
  GapLayer layer{number, 0.0, 0.0, {}};
  if (std::abs(a.r_m - a_end.r_m) < same_place_m) {
    const double across = pair.conductance_W_per_m2K * 0.5 * (a.r_m + b.r_m) * std::abs(std::log(b.r_m / a.r_m));
    layer.conductivity_r_W_per_mK = across;
    layer.conductivity_z_W_per_mK = along_share * across;
  } else if (std::abs(a.z_m - a_end.z_m) < same_place_m) {
    const double across = pair.conductance_W_per_m2K * std::abs(b.z_m - a.z_m);
    layer.conductivity_r_W_per_mK = along_share * across;
    layer.conductivity_z_W_per_mK = across;
  } else {
    throw rom::InputError(gap.where, gap.name, "a gap along neither r nor z cannot be exported to CalculiX");
  }
  std::map<std::size_t, std::size_t> opposite, across;
  for (const auto& [on_a, on_b] : opposite_nodes(deck, pair)) opposite[on_a] = on_b;
  const auto across_at = [&](std::size_t node) {
    const auto [found, added] = across.emplace(node, nodes.size());
    if (added) {
      const Point& from = deck.nodes[node];
      const Point& to = deck.nodes[opposite.at(node)];
      nodes.push_back({0.5 * (from.r_m + to.r_m), 0.5 * (from.z_m + to.z_m)});
    }
    return found->second;
  };
  for (const DeckSide& side : deck.sides_of_piece[pair.piece_a]) {
    const auto [from, to, middle] = nodes_of(deck, side);
    layer.elements.push_back(
        {to, from, opposite.at(from), opposite.at(to), middle, across_at(from), opposite.at(middle), across_at(to)});
  }
  return layer;
}

void write_nodes(DeckFile& file, const std::vector<Point>& nodes, std::size_t first) {
  file << "*NODE, NSET=ALL\n";
  for (std::size_t i = first; i < nodes.size(); ++i) {
    file << i + 1 << ", " << nodes[i].r_m << ", " << nodes[i].z_m << ", 0\n";
  }
}

void write_element(DeckFile& file, std::size_t number, const std::array<std::size_t, 8>& nodes) {
  file << number;
  for (const std::size_t node : nodes) file << ", " << node + 1;
  file << "\n";
}

void write_mesh(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "mesh.inc");
  write_nodes(file, deck.nodes, 0);
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    file << "** " << spindle.parts[part].name << "\n*ELEMENT, TYPE=CAX8, ELSET=" << name('P', part) << "\n";
    for (std::size_t e = 0; e < deck.elements.size(); ++e) {
      if (deck.part_of_element[e] == part) write_element(file, e + 1, deck.elements[e]);
    }
  }
  for (std::size_t m = 0; m < spindle.materials.size(); ++m) {
    const Material& material = spindle.materials[m];
    file << "** " << material.name << "\n*MATERIAL, NAME=" << name('M', m) << "\n*CONDUCTIVITY, TYPE=ORTHO\n"
         << material.conductivity_r_W_per_mK << ", " << material.conductivity_z_W_per_mK << ", "
         << material.conductivity_r_W_per_mK << "\n*DENSITY\n"
         << material.density_kg_per_m3 << "\n*SPECIFIC HEAT\n"
         << material.heat_capacity_J_per_kgK << "\n*ELASTIC\n"
         << material.youngs_modulus_Pa << ", " << material.poisson_ratio
         << "\n*EXPANSION, ZERO=" << degC(spindle.operating.reference_temperature_K) << "\n"
         << material.expansion_per_K << "\n";
  }
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    file << "*SOLID SECTION, ELSET=" << name('P', part) << ", MATERIAL=" << name('M', spindle.parts[part].material)
         << "\n";
  }
  file.close();
}

void write_surface(DeckFile& file, const DeckModel& deck, const std::string& surface, std::size_t piece) {
  file << "*SURFACE, NAME=" << surface << ", TYPE=ELEMENT\n";
  for (const DeckSide& side : deck.sides_of_piece[piece]) file << side.element + 1 << ", S" << side.side + 1 << "\n";
}

void write_exchange(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "exchange.inc");
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const auto pair = std::find_if(deck.pairs.begin(), deck.pairs.end(), [&](const DeckPair& candidate) {
      return candidate.kind == PieceKind::contact && candidate.index == i;
    });
    if (pair == deck.pairs.end()) continue;
    // With a linear pressure-overclosure the steady state is right and the transient is silently wrong.
    file << "** " << spindle.parts[spindle.contacts[i].part_a].name << " / "
         << spindle.parts[spindle.contacts[i].part_b].name << "\n*SURFACE INTERACTION, NAME=" << name('I', i)
         << "\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1.E12\n*FRICTION\n.5, 1.E12\n*GAP CONDUCTANCE\n"
         << pair->conductance_W_per_m2K << "\n";
  }
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    if (deck.pairs[p].kind != PieceKind::contact) continue;
    write_surface(file, deck, name('A', p), deck.pairs[p].piece_a);
    write_surface(file, deck, name('B', p), deck.pairs[p].piece_b);
    file << "*CONTACT PAIR, INTERACTION=" << name('I', deck.pairs[p].index)
         << ", TYPE=SURFACE TO SURFACE, ADJUST=1.E-6\n"
         << name('A', p) << ", " << name('B', p) << "\n";
  }
  std::vector<Point> nodes = deck.nodes;
  std::vector<GapLayer> layers;
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    if (deck.pairs[p].kind == PieceKind::gap) layers.push_back(make_layer(spindle, deck, p, nodes));
  }
  if (!layers.empty()) write_nodes(file, nodes, deck.nodes.size());
  std::size_t number = deck.elements.size();
  for (const GapLayer& layer : layers) {
    const std::string set = name('G', layer.pair);
    file << "** " << spindle.gap_films[deck.pairs[layer.pair].index].name << "\n*ELEMENT, TYPE=CAX8, ELSET=" << set
         << "\n";
    for (const auto& element : layer.elements) write_element(file, ++number, element);
    // No mass and no stiffness to speak of: the film stores nothing.
    file << "*MATERIAL, NAME=" << set << "\n*CONDUCTIVITY, TYPE=ORTHO\n"
         << layer.conductivity_r_W_per_mK << ", " << layer.conductivity_z_W_per_mK << ", "
         << along_share * layer.conductivity_r_W_per_mK << "\n*DENSITY\n1.E-6\n*SPECIFIC HEAT\n1.\n*ELASTIC\n1., .3\n"
         << "*SOLID SECTION, ELSET=" << set << ", MATERIAL=" << set << "\n";
  }
  file.close();
}

std::size_t air_number(const Spindle& spindle, std::size_t surrounding) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < surrounding; ++i) number += spindle.surroundings[i].kind == SurroundingKind::air ? 1 : 0;
  return number;
}

void write_films(DeckFile& file, const DeckModel& deck, std::size_t surrounding, double sink) {
  for (const DeckFilm& film : deck.films) {
    if (film.surrounding != surrounding) continue;
    for (const DeckSide& side : deck.sides_of_piece[film.piece]) {
      file << side.element + 1 << ", F" << side.side + 1 << ", " << sink << ", " << film.coefficient_W_per_m2K << "\n";
    }
  }
}

/// Loads of a step; the air's temperature is constant in the steady state and follows its history in the transient.
void write_loads(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan, const AirHistory& air,
                 bool steady, const std::string& directory) {
  DeckFile file(directory, steady ? "steady_loads.inc" : "transient_loads.inc");
  for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
    const bool is_air = spindle.surroundings[i].kind == SurroundingKind::air;
    file << "** " << spindle.surroundings[i].name << "\n";
    if (is_air && !steady) {
      file << "*FILM, AMPLITUDE=" << name('V', air_number(spindle, i)) << "\n";
      write_films(file, deck, i, 1.0);
    } else {
      file << "*FILM\n";
      write_films(file, deck, i, degC(is_air ? air.steady_K[air_number(spindle, i)] : plan.surrounding_K[i]));
    }
  }
  std::map<std::size_t, double> density_of_part;
  for (const DeckVolumeHeat& heat : deck.volume_heats) density_of_part[heat.part] += heat.density_W_per_m3;
  std::map<std::size_t, double> flux_of_piece;
  for (const DeckSurfaceHeat& heat : deck.surface_heats) flux_of_piece[heat.piece] += heat.flux_W_per_m2;
  if (!density_of_part.empty() || !flux_of_piece.empty()) file << "*DFLUX\n";
  for (const auto& [part, density] : density_of_part) file << name('P', part) << ", BF, " << density << "\n";
  for (const auto& [piece, flux] : flux_of_piece) {
    for (const DeckSide& side : deck.sides_of_piece[piece]) {
      file << side.element + 1 << ", S" << side.side + 1 << ", " << flux << "\n";
    }
  }
  file.close();
}

void write_step_end(DeckFile& file) {
  file << "*NODE PRINT, NSET=ALL, FREQUENCY=1000000\nNT\n*NODE FILE, OUTPUT=2D, FREQUENCY=1000000\nNT\n*END STEP\n";
}

void write_steady(const DeckPlan& plan, const std::string& directory) {
  DeckFile file(directory, "steady.inp");
  file << "*INCLUDE, INPUT=mesh.inc\n*INCLUDE, INPUT=exchange.inc\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, "
       << degC(plan.start_K)
       << "\n*STEP\n*HEAT TRANSFER, STEADY STATE, DIRECT\n1., 1.\n*INCLUDE, INPUT=steady_loads.inc\n";
  write_step_end(file);
  file.close();
}

/// Longer steps as the changes slow down; every stage holds an even number of them.
std::vector<TimeStage> time_stages(const DeckPlan& plan) {
  std::vector<TimeStage> stages;
  double from_s = 0.0;
  for (const double until_s : plan.output_times_s) {
    const double wanted_s = from_s < 60.0 ? 1.0 : from_s < 300.0 ? 3.0 : from_s < 900.0 ? 6.0 : 10.0;
    const double pairs = std::ceil(0.5 * (until_s - from_s) / wanted_s);
    stages.push_back({until_s, 0.5 * (until_s - from_s) / pairs});
    from_s = until_s;
  }
  return stages;
}

void write_transient(const DeckPlan& plan, const AirHistory& air, const std::string& directory,
                     const std::string& file_name, double step_factor) {
  DeckFile file(directory, file_name);
  file << "*INCLUDE, INPUT=mesh.inc\n*INCLUDE, INPUT=exchange.inc\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, "
       << degC(plan.start_K) << "\n";
  for (std::size_t v = 0; v < air.steady_K.size(); ++v) {
    file << "*AMPLITUDE, NAME=" << name('V', v) << ", TIME=TOTAL TIME\n";
    for (std::size_t i = 0; i < air.time_s.size(); ++i) {
      file << air.time_s[i] << ", " << degC(air.air_K[i][v]) << "\n";
    }
  }
  double from_s = 0.0;
  for (const TimeStage& stage : time_stages(plan)) {
    file << "*STEP, INC=1000000\n*HEAT TRANSFER, DIRECT\n"
         << step_factor * stage.step_s << ", " << stage.until_s - from_s << "\n";
    if (from_s == 0.0) file << "*INCLUDE, INPUT=transient_loads.inc\n";
    write_step_end(file);
    from_s = stage.until_s;
  }

  file.close();
}

void write_bonds(const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "bonds.inc");
  const std::vector<std::size_t> leader = bonded_leaders(deck);
  for (std::size_t node = 0; node < leader.size(); ++node) {
    if (leader[node] == node) continue;
    for (int direction = 1; direction <= 2; ++direction) {
      file << "*EQUATION\n2\n"
           << node + 1 << ", " << direction << ", 1., " << leader[node] + 1 << ", " << direction << ", -1.\n";
    }
  }
  std::map<std::size_t, bool> held;
  for (const std::size_t node : deck.supported_nodes) held[leader[node]] = true;
  file << "*BOUNDARY\n";
  for (const auto& [node, is_held] : held) file << node + 1 << ", 2, 2\n";
  for (std::size_t node = 0; node < leader.size(); ++node) {
    if (leader[node] == node && deck.nodes[node].r_m < same_place_m) file << node + 1 << ", 1, 1\n";
  }
  file.close();
}

/// One static analysis per temperature field; `run` makes the file of temperatures.
void write_growth(const Spindle& spindle, const std::string& directory, const std::string& state,
                  const std::string& temperatures) {
  DeckFile file(directory, "growth_" + state + ".inp");
  file << "*INCLUDE, INPUT=mesh.inc\n*INCLUDE, INPUT=bonds.inc\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, "
       << degC(spindle.operating.reference_temperature_K)
       << "\n*STEP\n*STATIC\n*TEMPERATURE\n*INCLUDE, INPUT=" << temperatures
       << ".inc\n*NODE PRINT, NSET=ALL\nU\n*NODE FILE, OUTPUT=2D\nU, NT\n*END STEP\n";
  file.close();
}

nlohmann::json as_json(const DeckRow& row) {
  nlohmann::json entries = nlohmann::json::array();
  for (const auto& [node, weight] : row) entries.push_back({node + 1, weight});
  return entries;
}

void write_outputs(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan, const AirHistory& air,
                   const std::string& directory) {
  nlohmann::ordered_json outputs;
  outputs["reference_temperature_degC"] = degC(spindle.operating.reference_temperature_K);
  outputs["start_degC"] = degC(plan.start_K);
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    nlohmann::ordered_json nodes = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < deck.nodes.size(); ++i) {
      if (deck.part_of_node[i] == part) nodes.push_back(i + 1);
    }
    outputs["parts"][spindle.parts[part].name] = std::move(nodes);
  }
  outputs["key_points"] = nlohmann::json::object();
  for (std::size_t k = 0; k < deck.key_points.size(); ++k) {
    outputs["key_points"][spindle.key_points[k].name] = as_json(deck.key_points[k]);
  }
  if (!deck.growth_left_out.empty()) outputs["growth_left_out"] = deck.growth_left_out;
  outputs["deformations"] = nlohmann::json::object();
  for (std::size_t d = 0; d < deck.deformations.size(); ++d) {
    const DeformationOutput& output = spindle.deformations[d];
    outputs["deformations"][output.name] = {{"direction", output.direction == Direction::radial ? 1 : 2},
                                            {"nodes", as_json(deck.deformations[d])}};
  }
  nlohmann::ordered_json increments = nlohmann::ordered_json::array();
  double from_s = 0.0;
  for (const TimeStage& stage : time_stages(plan)) {
    increments.push_back({{"until_s", stage.until_s}, {"count", std::lround((stage.until_s - from_s) / stage.step_s)}});
    from_s = stage.until_s;
  }
  outputs["transient_steps"] = std::move(increments);
  // For the balance of each air volume: the wetted sides with their coefficient, and the air's own temperature.
  outputs["air"] = nlohmann::json::object();
  for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
    if (spindle.surroundings[i].kind != SurroundingKind::air) continue;
    nlohmann::json sides = nlohmann::json::array();
    for (const DeckFilm& film : deck.films) {
      if (film.surrounding != i) continue;
      for (const DeckSide& side : deck.sides_of_piece[film.piece]) {
        const auto [a, b, middle] = nodes_of(deck, side);
        const Point &from = deck.nodes[a], &to = deck.nodes[b];
        sides.push_back({a + 1, b + 1, middle + 1, from.r_m, to.r_m, std::hypot(to.r_m - from.r_m, to.z_m - from.z_m),
                         film.coefficient_W_per_m2K});
      }
    }
    outputs["air"][spindle.surroundings[i].name] = {{"steady_degC", degC(air.steady_K[air_number(spindle, i)])},
                                                    {"sides", std::move(sides)}};
  }
  DeckFile file(directory, "outputs.json");
  file << outputs.dump() << "\n";
  file.close();
}

void write_calculix_readme(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "README");
  file
      << "CalculiX deck of the spindle '" << spindle.name << "' (SI, degC; axisymmetric, x = r, y = z; CAX8).\n"
      << "Run: ./run  (steady.inp, transient.inp, transient_double.inp, growth_*.inp in their order)\n"
      << "Temperatures (NT) and displacements (U) of all nodes: *.dat, fields: *.frd. The transient's steps are of "
         "first\n"
      << "order; transient_temperatures_*.inc hold twice its solution minus the one with doubled steps.\n"
      << "outputs.json: nodes of each part, and each key point and deformation as [node, weight] sums.\n"
      << "Air volumes are films to a temperature that is prescribed along time (steady_loads.inc, *AMPLITUDE V0...).\n";
  if (!deck.growth_left_out.empty()) file << "Without growth: " << deck.growth_left_out << "\n";
  file.close();
}

}  // namespace

void write_calculix_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan, const AirHistory& air,
                         const std::string& directory) {
  make_deck_folder(directory);
  write_mesh(spindle, deck, directory);
  write_exchange(spindle, deck, directory);
  write_loads(spindle, deck, plan, air, true, directory);
  write_loads(spindle, deck, plan, air, false, directory);
  write_steady(plan, directory);
  write_transient(plan, air, directory, "transient.inp", 1.0);
  write_transient(plan, air, directory, "transient_double.inp", 2.0);
  if (!deck.deformations.empty()) {
    write_bonds(deck, directory);
    write_growth(spindle, directory, "steady", "steady_temperatures_1");
    for (std::size_t i = 0; i < plan.output_times_s.size(); ++i) {
      write_growth(spindle, directory, std::to_string(std::lround(plan.output_times_s[i])) + "s",
                   "transient_temperatures_" + std::to_string(i + 1));
    }
  }
  write_outputs(spindle, deck, plan, air, directory);
  write_calculix_run(deck.nodes.size(), !deck.deformations.empty(), directory);
  write_calculix_readme(spindle, deck, directory);
}

}  // namespace spindle_twin::fem_offline
