#include "fem_offline/description/read_tables.hpp"

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

Film read_film(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts) {
  Film film;
  film.name = names.add(table);
  film.where = table.where("name");
  film.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
  film.surrounding = surroundings.find(table, "surrounding");
  film.regions = read_regions(table);
  film.only_parts = parts.find_all(table, "only_parts", table.strings_or_empty("only_parts"));
  film.law = read_speed_law(table);
  return film;
}

GapFilm read_gap_film(const TomlTable& table, Names& names, const Names& parts) {
  GapFilm gap;
  gap.name = names.add(table);
  gap.where = table.where("name");
  gap.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
  std::tie(gap.part_a, gap.part_b) = parts.find_pair(table, "between");
  gap.region = box_from(table, "region", table.numbers("region", 4, any_number), false);
  gap.law = read_speed_law(table);
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
  heat.heat_W = table.optional_number("heat_W", not_negative);
  heat.density_W_per_m3 = table.optional_number("density_W_per_m3", not_negative);
  heat.density_over = parts.find_all(table, "density_over", table.strings_or_empty("density_over"));
  heat.law = read_speed_law(table);
  double weights = 0.0;
  bool only_volumes = true;
  for (const auto& share : table.tables("shares")) {
    heat.shares.push_back(read_share(share, parts));
    weights += heat.shares.back().weight;
    only_volumes = only_volumes && !heat.shares.back().on_contact_with && !heat.shares.back().on_face;
  }
  if (heat.heat_W.has_value() == heat.density_W_per_m3.has_value()) {
    table.fail("heat_W", "a heat needs either heat_W or density_W_per_m3");
  }
  if (heat.heat_W && !heat.density_over.empty())
    table.fail("density_over", "goes with density_W_per_m3, not with heat_W");
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
  operating.reference_temperature_K = table.number("reference_temperature_degC", temperature_degC) + kelvin_at_0_degC;
  operating.surrounding_K.assign(surroundings.size(), operating.reference_temperature_K);
  const auto temperatures = table.table("temperatures_degC");
  for (const auto& key : temperatures.free_keys()) {
    if (surroundings[names.find(temperatures, key, key)].kind == SurroundingKind::air) {
      temperatures.fail(key, "an air volume finds its own temperature; only ambient and coolant are given");
    }
  }
  for (std::size_t i = 0; i < surroundings.size(); ++i) {
    if (surroundings[i].kind == SurroundingKind::air) continue;
    operating.surrounding_K[i] = temperatures.number(surroundings[i].name, temperature_degC) + kelvin_at_0_degC;
  }
  return operating;
}

}  // namespace spindle_twin::fem_offline
