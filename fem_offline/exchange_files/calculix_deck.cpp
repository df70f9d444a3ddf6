#include "fem_offline/exchange_files/calculix_deck.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "fem_offline/exchange_files/calculix_bonds.hpp"
#include "fem_offline/exchange_files/calculix_gaps.hpp"
#include "fem_offline/exchange_files/calculix_outputs.hpp"
#include "fem_offline/exchange_files/calculix_run.hpp"
#include "fem_offline/exchange_files/deck_files.hpp"

namespace spindle_twin::fem_offline {
namespace {

void write_mesh(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "mesh.inc");
  write_nodes(file, deck.nodes, 0);
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    file << "** " << spindle.parts[part].name << "\n*ELEMENT, TYPE=CAX8, ELSET=" << set_name('P', part) << "\n";
    for (std::size_t e = 0; e < deck.elements.size(); ++e) {
      if (deck.part_of_element[e] == part) write_element(file, e + 1, deck.elements[e]);
    }
  }
  for (std::size_t m = 0; m < spindle.materials.size(); ++m) {
    const Material& material = spindle.materials[m];
    file << "** " << material.name << "\n*MATERIAL, NAME=" << set_name('M', m) << "\n*CONDUCTIVITY, TYPE=ORTHO\n"
         << material.conductivity_r_W_per_mK << ", " << material.conductivity_z_W_per_mK << ", "
         << material.conductivity_r_W_per_mK << "\n*DENSITY\n"
         << material.density_kg_per_m3 << "\n*SPECIFIC HEAT\n"
         << material.heat_capacity_J_per_kgK << "\n*ELASTIC\n"
         << material.youngs_modulus_Pa << ", " << material.poisson_ratio
         << "\n*EXPANSION, ZERO=" << degC(spindle.operating.reference_temperature_K) << "\n"
         << material.expansion_per_K << "\n";
  }
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    file << "*SOLID SECTION, ELSET=" << set_name('P', part)
         << ", MATERIAL=" << set_name('M', spindle.parts[part].material) << "\n";
  }
  file.close();
}

void write_surface(DeckFile& file, const DeckModel& deck, const std::string& surface, std::size_t piece) {
  file << "*SURFACE, NAME=" << surface << ", TYPE=ELEMENT\n";
  for (const DeckSide& side : deck.sides_of_piece[piece]) file << side.element + 1 << ", S" << side.side + 1 << "\n";
}

void write_contact_pair(DeckFile& file, const DeckModel& deck, std::size_t pair, const std::string& interaction) {
  write_surface(file, deck, set_name('A', pair), deck.pairs[pair].piece_a);
  write_surface(file, deck, set_name('B', pair), deck.pairs[pair].piece_b);
  file << "*CONTACT PAIR, INTERACTION=" << interaction << ", TYPE=SURFACE TO SURFACE, ADJUST=1.E-6\n"
       << set_name('A', pair) << ", " << set_name('B', pair) << "\n";
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
         << spindle.parts[spindle.contacts[i].part_b].name << "\n*SURFACE INTERACTION, NAME=" << set_name('I', i)
         << "\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1.E12\n*FRICTION\n.5, 1.E12\n*GAP CONDUCTANCE\n"
         << pair->conductance_W_per_m2K << "\n";
  }
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    if (deck.pairs[p].kind == PieceKind::contact) write_contact_pair(file, deck, p, set_name('I', deck.pairs[p].index));
  }
  write_gap_layers(file, spindle, deck);
  file.close();
}

/// One *FILM block for the films that see the same fluid, or, without one, the same surrounding.
void write_film_block(DeckFile& file, const DeckModel& deck, const DeckFilm& first, const std::string& amplitude,
                      double sink) {
  file << "*FILM" << amplitude << "\n";
  for (const DeckFilm& film : deck.films) {
    if (film.surrounding != first.surrounding || film.fluid != first.fluid) continue;
    for (const DeckSide& side : deck.sides_of_piece[film.piece]) {
      file << side.element + 1 << ", F" << side.side + 1 << ", " << sink << ", " << film.coefficient_W_per_m2K << "\n";
    }
  }
}

/// Loads of a step; a fluid's temperature is constant in the steady state and follows its history in the transient.
void write_loads(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan, const FluidHistory& history,
                 bool steady, const std::string& directory) {
  DeckFile file(directory, steady ? "steady_loads.inc" : "transient_loads.inc");
  std::set<std::pair<std::size_t, std::optional<std::size_t>>> written;
  for (const DeckFilm& film : deck.films) {
    if (!written.emplace(film.surrounding, film.fluid).second) continue;
    file << "** " << (film.fluid ? deck.fluids[*film.fluid].name : spindle.surroundings[film.surrounding].name) << "\n";
    if (!film.fluid) {
      write_film_block(file, deck, film, "", degC(plan.surrounding_K[film.surrounding]));
    } else if (steady) {
      write_film_block(file, deck, film, "", degC(history.steady_K[*film.fluid]));
    } else {
      write_film_block(file, deck, film, ", AMPLITUDE=" + set_name('V', *film.fluid), 1.0);
    }
  }
  std::map<std::size_t, double> density_of_part;
  for (const DeckVolumeHeat& heat : deck.volume_heats) density_of_part[heat.part] += heat.density_W_per_m3;
  std::map<std::size_t, double> flux_of_piece;
  for (const DeckSurfaceHeat& heat : deck.surface_heats) flux_of_piece[heat.piece] += heat.flux_W_per_m2;
  if (!density_of_part.empty() || !flux_of_piece.empty()) file << "*DFLUX\n";
  for (const auto& [part, density] : density_of_part) file << set_name('P', part) << ", BF, " << density << "\n";
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

void write_transient(const DeckPlan& plan, const FluidHistory& history, const std::string& directory,
                     const std::string& file_name, double step_factor) {
  DeckFile file(directory, file_name);
  file << "*INCLUDE, INPUT=mesh.inc\n*INCLUDE, INPUT=exchange.inc\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, "
       << degC(plan.start_K) << "\n";
  for (std::size_t v = 0; v < history.steady_K.size(); ++v) {
    file << "*AMPLITUDE, NAME=" << set_name('V', v) << ", TIME=TOTAL TIME\n";
    for (std::size_t i = 0; i < history.time_s.size(); ++i) {
      file << history.time_s[i] << ", " << degC(history.fluid_K[i][v]) << "\n";
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

void write_calculix_readme(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "README");
  file << "CalculiX deck of the spindle '" << spindle.name << "' (SI, degC; axisymmetric, x = r, y = z; CAX8).\n"
       << "Run: ./run  (steady.inp, transient.inp, transient_double.inp, growth_*.inp in their order)\n"
       << "Temperatures (NT) and displacements (U) of all nodes: *.dat, fields: *.frd. The transient's steps are of "
          "first\n"
       << "order; transient_temperatures_*.inc hold twice its solution minus the one with doubled steps.\n"
       << "outputs.json: nodes of each part, and each key point and deformation as [node, weight] sums.\n"
       << "Volumes of air, and the liquid that enters each segment of a coolant circuit, are films to a temperature "
          "that "
          "is\nprescribed along time (steady_loads.inc, *AMPLITUDE V0...), from our own solution.\n";
  if (!deck.growth_left_out.empty()) file << "Without growth: " << deck.growth_left_out << "\n";
  file.close();
}

}  // namespace

void write_calculix_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                         const FluidHistory& history, const std::string& directory) {
  make_deck_folder(directory);
  write_mesh(spindle, deck, directory);
  write_exchange(spindle, deck, directory);
  write_loads(spindle, deck, plan, history, true, directory);
  write_loads(spindle, deck, plan, history, false, directory);
  write_steady(plan, directory);
  write_transient(plan, history, directory, "transient.inp", 1.0);
  write_transient(plan, history, directory, "transient_double.inp", 2.0);
  if (!deck.deformations.empty()) {
    write_calculix_bonds(deck, directory);
    write_growth(spindle, directory, "steady", "steady_temperatures_1");
    for (std::size_t i = 0; i < plan.output_times_s.size(); ++i) {
      write_growth(spindle, directory, std::to_string(std::lround(plan.output_times_s[i])) + "s",
                   "transient_temperatures_" + std::to_string(i + 1));
    }
  }
  write_calculix_outputs(spindle, deck, plan, history, directory);
  write_calculix_run(deck.nodes.size(), !deck.deformations.empty(), directory);
  write_calculix_readme(spindle, deck, directory);
}

}  // namespace spindle_twin::fem_offline
