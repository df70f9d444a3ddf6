#include "fem_offline/description/read_tables.hpp"
#include "rom/units.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>

namespace spindle_twin::fem_offline {

using rom::any_number;
using rom::between;
using rom::not_negative;
using rom::positive;

Surrounding read_surrounding(const TomlTable& table, Names& names) {
  Surrounding surrounding;
  surrounding.name = names.add(table);
  surrounding.where = table.where("name");
  const std::string kind = table.choice("kind", {"ambient", "coolant", "air"});
  surrounding.kind = kind == "ambient"   ? SurroundingKind::ambient
                     : kind == "coolant" ? SurroundingKind::coolant
                                         : SurroundingKind::air;
  if (surrounding.kind == SurroundingKind::air)
    surrounding.capacity_J_per_K = table.number("capacity_J_per_K", positive);
  return surrounding;
}

namespace {

Film read_film_places(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts) {
  Film film;
  film.name = names.add(table);
  film.where = table.where("name");
  film.surrounding = surroundings.find(table, "surrounding");
  film.regions = read_regions(table);
  film.only_parts = parts.find_all(table, "only_parts", table.strings_or_empty("only_parts"));
  return film;
}

// σ in W/m²K⁴, exact by the SI's definitions of 2019 (CODATA).
constexpr double stefan_boltzmann_W_per_m2K4 = 5.670374419e-8;

// A wall behind the coefficient c k / h stays below the prescribed temperature by h/c times the gradient at the wall:
// with 1e7 by 1e-7 of what one whole element may differ, and the stiffest entry is 1e7 of an element's own, which
// leaves a direct solution nine digits.
constexpr double prescribed_over_element = 1e7;

}  // namespace

Film read_film(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts) {
  Film film = read_film_places(table, names, surroundings, parts);
  if (rom::has_law(table, {"coefficient_W_per_m2K", "speed_law"})) return film;
  film.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
  film.law = read_speed_law(table);
  return film;
}

Film read_prescribed_temperature(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts) {
  Film film = read_film_places(table, names, surroundings, parts);
  film.kind = FilmKind::prescribed_temperature;
  return film;
}

Film read_radiation(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts) {
  Film film = read_film_places(table, names, surroundings, parts);
  film.kind = FilmKind::radiation;
  const double emissivity = table.number("emissivity", {0.0, 1.0, true, false});
  const double mean_K = table.number("mean_temperature_degC", temperature_degC) + rom::zero_degC_K;
  film.coefficient_W_per_m2K = 4.0 * emissivity * stefan_boltzmann_W_per_m2K4 * mean_K * mean_K * mean_K;
  return film;
}

void set_prescribed_coefficients(Spindle& spindle) {
  for (Film& film : spindle.films) {
    if (film.kind != FilmKind::prescribed_temperature) continue;
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

GapFilm read_gap_film(const TomlTable& table, Names& names, const Names& parts) {
  GapFilm gap;
  gap.name = names.add(table);
  gap.where = table.where("name");
  const bool physical = rom::has_law(table, {"coefficient_W_per_m2K", "speed_law"});
  if (!physical) gap.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
  std::tie(gap.part_a, gap.part_b) = parts.find_pair(table, "between");
  gap.region = box_from(table, "region", table.numbers("region", 4, any_number), false);
  if (!physical) gap.law = read_speed_law(table);
  return gap;
}

namespace {

HeatShare read_share(const TomlTable& table, const Names& parts) {
  HeatShare share;
  share.part = parts.find(table, "part");
  share.weight = table.number_or("weight", 1.0, positive);
  if (table.has("on_contact_with")) {
    share.on_contact_with = parts.find(table, "on_contact_with");
    if (share.on_contact_with == share.part) table.fail("on_contact_with", "must be another part than \"part\"");
  }
  if (table.has("on_face")) share.on_face = read_face(table, "on_face");
  if (share.on_contact_with && share.on_face) table.fail("on_face", "cannot stand beside on_contact_with");
  return share;
}

}  // namespace

HeatSource read_heat(const TomlTable& table, Names& names, const Names& parts) {
  HeatSource heat;
  heat.name = names.add(table);
  heat.where = table.where("name");
  const bool physical =
      rom::has_law(table, {"heat_W", "density_W_per_m3", "flux_W_per_m2", "density_over", "speed_law", "friction"});
  heat.heat_W = physical ? 0.0 : table.optional_number("heat_W", not_negative);
  heat.density_W_per_m3 = table.optional_number("density_W_per_m3", not_negative);
  heat.flux_W_per_m2 = table.optional_number("flux_W_per_m2", not_negative);
  heat.density_over = parts.find_all(table, "density_over", table.strings_or_empty("density_over"));
  if (!physical) {
    heat.law = read_speed_law(table);
    heat.friction = rom::read_friction(table, heat.law);
  }
  double weights = 0.0;
  bool only_volumes = true, only_faces = true;
  for (const auto& share : table.tables("shares")) {
    heat.shares.push_back(read_share(share, parts));
    weights += heat.shares.back().weight;
    const bool in_volume = !heat.shares.back().on_contact_with && !heat.shares.back().on_face;
    only_volumes = only_volumes && in_volume;
    only_faces = only_faces && !in_volume;
  }
  if (heat.heat_W.has_value() + heat.density_W_per_m3.has_value() + heat.flux_W_per_m2.has_value() != 1) {
    table.fail("heat_W", "a heat needs either heat_W or density_W_per_m3 or flux_W_per_m2 or law");
  }
  if (!heat.density_W_per_m3 && !heat.density_over.empty()) {
    table.fail("density_over", heat.heat_W ? "goes with density_W_per_m3, not with heat_W"
                                           : "goes with density_W_per_m3, not with flux_W_per_m2");
  }
  if (heat.flux_W_per_m2) {
    if (!only_faces) table.fail("shares", "a flux acts on faces: every share needs on_face or on_contact_with");
    return heat;
  }
  if (heat.heat_W || !heat.density_over.empty()) {
    if (std::abs(weights - 1.0) > 1e-9) {
      std::ostringstream text;
      text << "the weights must add up to 1, they make " << weights;
      table.fail("shares", text.str());
    }
  } else if (!only_volumes) {
    table.fail("shares", "a density without density_over acts in volumes only, not on faces");
  }
  return heat;
}

Operating read_operating(const TomlTable& table, const std::vector<Surrounding>& surroundings, const Names& names) {
  Operating operating;
  operating.speed_rpm = table.number("speed_rpm", positive);
  operating.load = table.number_or("load", 1.0, not_negative);
  operating.reference_temperature_K = table.number("reference_temperature_degC", temperature_degC) + rom::zero_degC_K;
  operating.surrounding_K.assign(surroundings.size(), operating.reference_temperature_K);
  const auto temperatures = table.table("temperatures_degC");
  for (const auto& key : temperatures.free_keys()) {
    if (surroundings[names.find(temperatures, key, key)].kind == SurroundingKind::air) {
      temperatures.fail(key, "an air volume finds its own temperature; only ambient and coolant are given");
    }
  }
  for (std::size_t i = 0; i < surroundings.size(); ++i) {
    if (surroundings[i].kind == SurroundingKind::air) continue;
    operating.surrounding_K[i] = temperatures.number(surroundings[i].name, temperature_degC) + rom::zero_degC_K;
  }
  return operating;
}

}  // namespace spindle_twin::fem_offline
