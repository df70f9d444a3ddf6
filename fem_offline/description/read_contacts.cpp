#include <algorithm>
#include <tuple>

#include "fem_offline/description/read_tables.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {

using rom::any_number;
using rom::not_negative;
using rom::positive;

namespace {

InterferenceFit read_fit(const TomlTable& table) {
  InterferenceFit fit;
  fit.inner_radius_m = table.number("inner_radius_mm", length_mm) * metre_per_mm;
  fit.fit_radius_m = table.number("fit_radius_mm", length_mm) * metre_per_mm;
  fit.outer_radius_m = table.number("outer_radius_mm", length_mm) * metre_per_mm;
  fit.interference_m = table.number("interference_um", not_negative) * rom::m_per_um;
  if (!(fit.inner_radius_m < fit.fit_radius_m && fit.fit_radius_m < fit.outer_radius_m)) {
    table.fail("fit_radius_mm", "must lie between inner_radius_mm and outer_radius_mm");
  }
  return fit;
}

void refuse_second_contact(const TomlTable& table, const Contact& contact, const std::vector<Contact>& others) {
  for (const Contact& other : others) {
    if (std::minmax(contact.part_a, contact.part_b) != std::minmax(other.part_a, other.part_b)) continue;
    table.fail("between", "this contact is declared already in line " + std::to_string(other.where.line));
  }
}

rom::LawDefaults both_parts(std::size_t part_a, std::size_t part_b) {
  return {static_cast<int>(part_a), static_cast<int>(part_b)};
}

}  // namespace

void read_contact(const TomlTable& table, Reading& into) {
  Contact contact;
  contact.where = table.where("between");
  const auto names = table.strings("between");
  if (names.size() == 2) table.show_as(names[0] + "-" + names[1]);
  std::tie(contact.part_a, contact.part_b) = into.parts.find_pair(table, "between");
  if (!rom::has_law(table, {"conductance_W_per_m2K"})) {
    contact.conductance_W_per_m2K = table.number("conductance_W_per_m2K", positive);
  }
  if (const auto fit = table.optional_table("interference_fit")) {
    if (into.spindle.geometry == Geometry::planar) {
      table.fail("interference_fit", "a planar geometry has no rings to fit");
    }
    contact.fit = read_fit(*fit);
  }
  contact.preload_pressure_Pa = table.optional_number("preload_pressure_Pa", not_negative);
  auto& contacts = into.spindle.contacts;
  refuse_second_contact(table, contact, contacts);
  keep_law(table, LawOwner::contact, contacts.size(), both_parts(contact.part_a, contact.part_b), into);
  contacts.push_back(std::move(contact));
}

void read_gap_film(const TomlTable& table, Reading& into) {
  GapFilm gap;
  gap.name = into.films.add(table);
  gap.where = table.where("name");
  const bool physical = rom::has_law(table, {"coefficient_W_per_m2K", "speed_law"});
  if (!physical) gap.coefficient_W_per_m2K = table.number("coefficient_W_per_m2K", positive);
  std::tie(gap.part_a, gap.part_b) = into.parts.find_pair(table, "between");
  gap.region = box_from(table, "region", table.numbers("region", 4, any_number), false);
  if (!physical) gap.law = read_speed_law(table);
  auto& gaps = into.spindle.gap_films;
  keep_law(table, LawOwner::gap_film, gaps.size(), both_parts(gap.part_a, gap.part_b), into);
  gaps.push_back(std::move(gap));
}

}  // namespace spindle_twin::fem_offline
