#include "fem_offline/description/read_tables.hpp"
#include "rom/units.hpp"

#include <cmath>
#include <sstream>

namespace spindle_twin::fem_offline {

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

namespace {

/// What the heat is given by, and what its shares may then be.
void check_heat(const TomlTable& table, const HeatSource& heat) {
  double weights = 0.0;
  bool only_volumes = true, only_faces = true;
  for (const HeatShare& share : heat.shares) {
    weights += share.weight;
    const bool in_volume = !share.on_contact_with && !share.on_face;
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
    return;
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
}

}  // namespace

void read_heat(const TomlTable& table, Reading& into) {
  HeatSource heat;
  heat.name = into.heats.add(table);
  heat.where = table.where("name");
  const bool physical =
      rom::has_law(table, {"heat_W", "density_W_per_m3", "flux_W_per_m2", "density_over", "speed_law", "friction"});
  heat.heat_W = physical ? 0.0 : table.optional_number("heat_W", not_negative);
  heat.density_W_per_m3 = table.optional_number("density_W_per_m3", not_negative);
  heat.flux_W_per_m2 = table.optional_number("flux_W_per_m2", not_negative);
  heat.density_over = into.parts.find_all(table, "density_over", table.strings_or_empty("density_over"));
  if (!physical) {
    heat.law = read_speed_law(table);
    heat.friction = rom::read_friction(table, heat.law);
  }
  for (const auto& share : table.tables("shares")) heat.shares.push_back(read_share(share, into.parts));
  check_heat(table, heat);
  keep_law(table, LawOwner::heat, into.spindle.heats.size(), {}, into);
  into.spindle.heats.push_back(std::move(heat));
}

Operating read_operating(const TomlTable& table, const std::vector<Surrounding>& surroundings, const Names& names) {
  Operating operating;
  operating.speed_rpm = table.number("speed_rpm", positive);
  operating.load = table.number_or("load", 1.0, not_negative);
  operating.reference_temperature_K = table.number("reference_temperature_degC", temperature_degC) + rom::zero_degC_K;
  operating.where = table.where("reference_temperature_degC");
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
