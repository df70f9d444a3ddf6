#include <algorithm>
#include <array>

#include "fem_offline/description/read_tables.hpp"

namespace spindle_twin::fem_offline {
namespace {

using rom::any_number;
using rom::positive;

Point read_point(const TomlTable& table, Geometry geometry) {
  const auto at_mm = table.numbers("at", 2, coordinate_mm(geometry));
  return {at_mm[0] * metre_per_mm, at_mm[1] * metre_per_mm};
}

/// "face" or "at"; the point comes back only if it was given.
std::optional<Point> read_place(const TomlTable& table, Geometry geometry, Box& face) {
  const bool has_face = table.has("face"), has_point = table.has("at");
  if (has_face == has_point) table.fail("face", "needs either a face [r0, r1, z0, z1] or a point at [r, z]");
  if (has_face) {
    face = read_face(table, "face");
    return std::nullopt;
  }
  return read_point(table, geometry);
}

ContactPressureOutput read_contact_pressure(const TomlTable& table, Names& names, const Names& parts,
                                            const std::vector<Contact>& contacts) {
  ContactPressureOutput output;
  output.name = names.add(table);
  output.where = table.where("name");
  const auto [a, b] = parts.find_pair(table, "between");
  const auto found = std::find_if(contacts.begin(), contacts.end(), [pair = std::minmax(a, b)](const Contact& contact) {
    return std::minmax(contact.part_a, contact.part_b) == pair;
  });
  if (found == contacts.end()) table.fail("between", "these parts have no contact");
  output.contact = static_cast<std::size_t>(found - contacts.begin());
  return output;
}

/// Every joint that was put together with a pressure has its own output, "part_a/part_b".
void add_pressures_of_joints(Spindle& spindle) {
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const Contact& contact = spindle.contacts[i];
    if (!contact.fit && !contact.preload_pressure_Pa) continue;
    if (std::any_of(spindle.contact_pressures.begin(), spindle.contact_pressures.end(),
                    [i](const ContactPressureOutput& output) { return output.contact == i; })) {
      continue;
    }
    spindle.contact_pressures.push_back(
        {spindle.parts[contact.part_a].name + "/" + spindle.parts[contact.part_b].name, i, contact.where});
  }
}

}  // namespace

Support read_support(const TomlTable& table, const Names& parts, Geometry geometry) {
  Support support;
  support.part = parts.find(table, "part");
  support.where = table.where(table.has("at") ? "at" : "face");
  if (const auto at = read_place(table, geometry, support.face)) {
    support.face = {at->r_m, at->r_m, at->z_m, at->z_m};
  }
  const auto stiffness_r = table.optional_number("stiffness_r_N_per_m", positive);
  const auto stiffness_z = table.optional_number("stiffness_z_N_per_m", positive);
  const bool is_spring = stiffness_r || stiffness_z;
  const bool stays_plane = table.boolean_or("stays_plane", false);
  if (is_spring + stays_plane + table.has("holds") > 1) {
    table.fail("holds",
               "a support either holds, or is a spring (stiffness_r_N_per_m, stiffness_z_N_per_m), or stays_plane");
  }
  if (is_spring) {
    support.hold_r = stiffness_r ? Hold::spring : Hold::free;
    support.hold_z = stiffness_z ? Hold::spring : Hold::free;
    support.stiffness_r_N_per_m = stiffness_r.value_or(0.0);
    support.stiffness_z_N_per_m = stiffness_z.value_or(0.0);
    return support;
  }
  if (stays_plane) {
    if (support.is_point()) table.fail("stays_plane", "a face can stay plane, a point cannot");
    support.hold_z = Hold::plane;
    return support;
  }
  const std::string holds = table.choice_or("holds", "z", {"z", "r", "rz"});
  support.hold_r = holds == "z" ? Hold::free : Hold::fixed;
  support.hold_z = holds == "r" ? Hold::free : Hold::fixed;
  return support;
}

DeformationOutput read_deformation(const TomlTable& table, Names& names, const Names& parts, Geometry geometry) {
  DeformationOutput output;
  // Read before the own name is added: an output can only be taken from those before it.
  if (table.has("minus")) output.minus = names.find(table, "minus");
  output.name = names.add(table);
  output.where = table.where("name");
  output.part = parts.find(table, "part");
  output.at = read_place(table, geometry, output.face);
  const std::string positive_along = table.choice("positive_along", {"+z", "-z", "+r", "-r"});
  output.sign = positive_along[0] == '+' ? 1.0 : -1.0;
  output.direction = positive_along[1] == 'z' ? Direction::axial : Direction::radial;
  return output;
}

void read_mechanics(const TomlTable& root, const Names& parts, Spindle& spindle) {
  Names pressures("contact pressure"), probes("stress probe");
  for (const auto& table : root.tables_or_empty("contact_pressure")) {
    spindle.contact_pressures.push_back(read_contact_pressure(table, pressures, parts, spindle.contacts));
  }
  for (const auto& table : root.tables_or_empty("stress_probe")) {
    const std::string name = probes.add(table);
    spindle.stress_probes.push_back(
        {name, parts.find(table, "part"), read_point(table, spindle.geometry), table.where("name")});
  }
  if (const auto table = root.optional_table("imposed_temperature")) {
    spindle.imposed_temperature = ImposedTemperature{table->string("rise_K"), table->where("rise_K")};
  }
  if (!spindle.supports.empty()) {
    add_pressures_of_joints(spindle);
    return;
  }
  if (!spindle.deformations.empty())
    root.fail("deformation", "a deformation output needs a support that holds the spindle");
  if (!spindle.contact_pressures.empty()) {
    root.fail("contact_pressure", "a contact pressure needs a support that holds the spindle");
  }
  if (!spindle.stress_probes.empty()) root.fail("stress_probe", "a stress needs a support that holds the spindle");
}

}  // namespace spindle_twin::fem_offline
