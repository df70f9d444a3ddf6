#include "fem_offline/description/face_conditions.hpp"

#include <algorithm>
#include <stdexcept>

#include "fem_offline/description/read_tables.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {

using rom::positive;

namespace {

// σ in W/m²K⁴, exact by the SI's definitions of 2019 (CODATA).
constexpr double stefan_boltzmann_W_per_m2K4 = 5.670374419e-8;

// A wall behind the coefficient c k / h stays below the prescribed temperature by h/c times the gradient at the wall:
// with 1e7 by 1e-7 of what one whole element may differ, and the stiffest entry is 1e7 of an element's own, which
// leaves a direct solution nine digits.
constexpr double prescribed_over_element = 1e7;

/// Name, surrounding and faces of what exchanges heat with a surrounding.
Film film_from(std::string_view condition, const TomlTable& table, Reading& into) {
  Film film;
  film.condition = &face_condition(condition);
  film.name = into.films.add(table);
  film.where = table.where("name");
  film.surrounding = into.surroundings.find(table, "surrounding");
  film.regions = read_regions(table);
  film.only_parts = into.parts.find_all(table, "only_parts", table.strings_or_empty("only_parts"));
  return film;
}

void read_film(const TomlTable& table, Reading& into) {
  Film film = film_from("film", table, into);
  if (!rom::has_law(table, {"coefficient_W_per_m2K", "speed_law"})) {
    film.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
    film.law = read_speed_law(table);
  }
  if (const auto law = table.optional_table("law")) {
    into.laws.push_back(law_of_film(*law, film, into.spindle.films.size(), into.spindle));
  }
  into.spindle.films.push_back(std::move(film));
}

void read_prescribed_temperature(const TomlTable& table, Reading& into) {
  into.spindle.films.push_back(film_from("prescribed_temperature", table, into));
}

void read_radiation(const TomlTable& table, Reading& into) {
  Film film = film_from("radiation", table, into);
  const double emissivity = table.number("emissivity", {0.0, 1.0, true, false});
  const double mean_K = table.number("mean_temperature_degC", temperature_degC) + rom::zero_degC_K;
  film.coefficient_W_per_m2K = 4.0 * emissivity * stefan_boltzmann_W_per_m2K4 * mean_K * mean_K * mean_K;
  into.spindle.films.push_back(std::move(film));
}

void read_adiabatic(const TomlTable& table, Reading& into) {
  Adiabatic adiabatic;
  adiabatic.name = into.adiabatics.add(table);
  adiabatic.where = table.where("name");
  adiabatic.regions = read_regions(table);
  into.spindle.adiabatics.push_back(std::move(adiabatic));
}

constexpr FaceMark contact_mark{.width_px = 2.6, .legend_width_px = 2.6, .colour = {{0.10, 0.10, 0.12, 1.0}}};
constexpr FaceMark gap_mark{.colour = {{0.95, 0.55, 0.00, 1.0}}, .legend = "gap: "};
constexpr FaceMark film_mark{.offset_px = 1.6, .legend_width_px = 6.4};
constexpr FaceMark prescribed_mark{.offset_px = 1.6,
                                   .width_px = 7.2,
                                   .legend_width_px = 7.2,
                                   .dashes_px = {5.0, 5.0},
                                   .white_dashes = true,
                                   .legend = "prescribed "};
constexpr FaceMark radiation_mark{
    .offset_px = 8.0, .dashes_px = {2.0, 5.0}, .colour = {{0.75, 0.10, 0.55, 1.0}}, .legend = "radiation "};
constexpr FaceMark adiabatic_mark{.width_px = 3.0,
                                  .legend_width_px = 3.0,
                                  .dashes_px = {6.0, 4.0},
                                  .colour = {{0.55, 0.55, 0.58, 1.0}},
                                  .legend = "adiabatic"};
constexpr FaceMark heat_mark{.offset_px = -5.0,
                             .width_px = 4.5,
                             .legend_width_px = 4.5,
                             .dashes_px = {3.0, 4.0},
                             .colour = {{0.86, 0.25, 0.05, 0.75}}};

// Table, reader, words and field of messages, piece, then {finds, claims, assembles, mark, why it is not exported}.
constexpr std::array<FaceCondition, 8> conditions{{
    {"contact", read_contact, "contact", "contact", PieceKind::contact,  //
     Finds::touching_parts, Claims::alone, Assembles::conductance, contact_mark},
    {"film", read_film, "film", "film", PieceKind::film,  //
     Finds::faces_towards_voids, Claims::alone, Assembles::conductance, film_mark},
    {"prescribed_temperature", read_prescribed_temperature, "film", "film", PieceKind::film,  //
     Finds::faces_towards_voids, Claims::alone, Assembles::held_temperature, prescribed_mark},
    {"radiation", read_radiation, "film", "film", PieceKind::film,  //
     Finds::faces_towards_voids, Claims::beside, Assembles::conductance, radiation_mark,
     "radiation cannot be exported; state it as a film"},
    {"coolant_circuit", read_coolant_circuit, "film", "film", PieceKind::film,  //
     Finds::faces_towards_voids, Claims::alone, Assembles::conductance, film_mark},
    {"gap_film", read_gap_film, "gap_film", "gap_film", PieceKind::gap,  //
     Finds::walls_of_a_gap, Claims::alone, Assembles::conductance, gap_mark},
    {"adiabatic", read_adiabatic, "adiabatic region", "adiabatic", PieceKind::adiabatic,  //
     Finds::faces_towards_voids, Claims::alone, Assembles::nothing, adiabatic_mark},
    {"heat", read_heat, "heat", "heat", std::nullopt,  //
     Finds::faces_in_a_box, Claims::beside, Assembles::heat, heat_mark},
}};

}  // namespace

std::span<const FaceCondition> face_conditions() { return conditions; }

const FaceCondition& face_condition(std::string_view table) {
  const auto row =
      std::find_if(conditions.begin(), conditions.end(), [&](const FaceCondition& one) { return one.table == table; });
  if (row == conditions.end()) throw std::logic_error("no condition at faces is called " + std::string(table));
  return *row;
}

const FaceCondition& face_condition(const Spindle& spindle, PieceKind piece, std::size_t index) {
  if (piece == PieceKind::film) return *spindle.films[index].condition;
  return face_condition(piece == PieceKind::contact ? "contact" : piece == PieceKind::gap ? "gap_film" : "adiabatic");
}

const FaceCondition* plain_film() { return &face_condition("film"); }

std::vector<FaceItem> face_items(const Spindle& spindle) {
  std::vector<FaceItem> items;
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const Contact& contact = spindle.contacts[i];
    items.push_back({&face_condition("contact"),
                     i,
                     spindle.parts[contact.part_a].name + "-" + spindle.parts[contact.part_b].name,
                     {contact.part_a, contact.part_b},
                     {},
                     contact.where});
  }
  for (std::size_t i = 0; i < spindle.gap_films.size(); ++i) {
    const GapFilm& gap = spindle.gap_films[i];
    items.push_back({&face_condition("gap_film"), i, gap.name, {gap.part_a, gap.part_b}, {gap.region}, gap.where});
  }
  for (std::size_t i = 0; i < spindle.films.size(); ++i) {
    const Film& film = spindle.films[i];
    items.push_back({film.condition, i, film.name, film.only_parts, film.regions, film.where});
  }
  for (std::size_t i = 0; i < spindle.adiabatics.size(); ++i) {
    const Adiabatic& adiabatic = spindle.adiabatics[i];
    items.push_back({&face_condition("adiabatic"), i, adiabatic.name, {}, adiabatic.regions, adiabatic.where});
  }
  for (std::size_t i = 0; i < spindle.heats.size(); ++i) {
    const HeatSource& heat = spindle.heats[i];
    for (const HeatShare& share : heat.shares) {
      if (share.on_face)
        items.push_back({&face_condition("heat"), i, heat.name, {share.part}, {*share.on_face}, heat.where});
    }
  }
  return items;
}

void set_prescribed_coefficients(Spindle& spindle) {
  for (Film& film : spindle.films) {
    if (film.condition->assembles != Assembles::held_temperature) continue;
    double conductivity_W_per_mK = 0.0;
    for (std::size_t p = 0; p < spindle.parts.size(); ++p) {
      const auto& only = film.only_parts;
      if (!only.empty() && std::find(only.begin(), only.end(), p) == only.end()) continue;
      const Material& material = spindle.materials[spindle.parts[p].material];
      conductivity_W_per_mK =
          std::max({conductivity_W_per_mK, material.conductivity_r_W_per_mK, material.conductivity_z_W_per_mK});
    }
    film.coefficient_W_per_m2K = prescribed_over_element * conductivity_W_per_mK / spindle.mesh.element_size_m;
  }
}

}  // namespace spindle_twin::fem_offline
