#include "fem_offline/description/read_tables.hpp"

#include <algorithm>
#include <tuple>

namespace spindle_twin::fem_offline {

using rom::between;
using rom::not_negative;
using rom::positive;

namespace {

constexpr rom::Range element_size_mm = between(0.01, 1000.0);

}  // namespace

MeshSettings read_mesh(const TomlTable& root) {
  MeshSettings mesh;
  const auto table = root.optional_table("mesh");
  if (!table) return mesh;
  mesh.element_size_m = table->number_or("element_size_mm", 4.0, element_size_mm) * metre_per_mm;
  mesh.degree = static_cast<int>(table->integer_or("degree", 2, 1, 4));
  mesh.cells_across = static_cast<int>(table->integer_or("cells_across", 1, 1, 20));
  if (const auto size_mm = table->optional_number("contact_element_size_mm", element_size_mm)) {
    mesh.contact_size_m = *size_mm * metre_per_mm;
  }
  // A 200th of the element size: the error of the outline stays below that of the elements along it.
  mesh.arc_sagitta_m =
      table->number_or("arc_sagitta_mm", mesh.element_size_m / metre_per_mm / 200.0, between(1e-5, 100.0)) *
      metre_per_mm;
  return mesh;
}

Material read_material(const TomlTable& table, Names& names) {
  Material material;
  material.name = names.add(table);
  material.where = table.where("name");
  material.conductivity_r_W_per_mK = table.number("conductivity_r_W_per_mK", positive);
  material.conductivity_z_W_per_mK =
      table.number_or("conductivity_z_W_per_mK", material.conductivity_r_W_per_mK, positive);
  material.density_kg_per_m3 = table.number("density_kg_per_m3", positive);
  material.heat_capacity_J_per_kgK = table.number("heat_capacity_J_per_kgK", positive);
  material.youngs_modulus_Pa = table.number("youngs_modulus_Pa", positive);
  material.poisson_ratio = table.number("poisson_ratio", {0.0, 0.5, false, true});
  material.expansion_per_K = table.number("expansion_per_K", not_negative);
  return material;
}

Part read_part(const TomlTable& table, Names& names, const Names& materials, Geometry geometry,
               const MeshSettings& mesh) {
  Part part;
  part.name = names.add(table);
  part.where = table.where("name");
  part.material = materials.find(table, "material");
  part.shapes = read_shapes(table, "rectangles", "polygons", geometry, mesh);
  part.cuts = read_shapes(table, "cut_rectangles", "cut_polygons", geometry, mesh);
  if (const auto size_mm = table.optional_number("element_size_mm", element_size_mm)) {
    part.element_size_m = *size_mm * metre_per_mm;
  }
  if (const auto initial_degC = table.optional_number("initial_degC", temperature_degC)) {
    part.initial_K = *initial_degC + kelvin_at_0_degC;
  }
  if (part.shapes.empty()) table.fail("rectangles", "a part needs at least one rectangle or polygon");
  return part;
}

Contact read_contact(const TomlTable& table, const Names& parts, Geometry geometry) {
  Contact contact;
  contact.where = table.where("between");
  const auto names = table.strings("between");
  if (names.size() == 2) table.show_as(names[0] + "-" + names[1]);
  std::tie(contact.part_a, contact.part_b) = parts.find_pair(table, "between");
  contact.conductance_W_per_m2K = table.number("conductance_W_per_m2K", positive);
  if (const auto fit = table.optional_table("interference_fit")) {
    if (geometry == Geometry::planar) table.fail("interference_fit", "a planar geometry has no rings to fit");
    InterferenceFit read;
    read.inner_radius_m = fit->number("inner_radius_mm", length_mm) * metre_per_mm;
    read.fit_radius_m = fit->number("fit_radius_mm", length_mm) * metre_per_mm;
    read.outer_radius_m = fit->number("outer_radius_mm", length_mm) * metre_per_mm;
    read.interference_m = fit->number("interference_um", not_negative) * metre_per_um;
    if (!(read.inner_radius_m < read.fit_radius_m && read.fit_radius_m < read.outer_radius_m)) {
      fit->fail("fit_radius_mm", "must lie between inner_radius_mm and outer_radius_mm");
    }
    contact.fit = read;
  }
  contact.preload_pressure_Pa = table.optional_number("preload_pressure_Pa", not_negative);
  return contact;
}

void check_contacts_once(const std::vector<Contact>& contacts, const std::vector<TomlTable>& tables) {
  std::map<std::pair<std::size_t, std::size_t>, int> lines;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto pair = std::minmax(contacts[i].part_a, contacts[i].part_b);
    const auto [known, fresh] = lines.try_emplace({pair.first, pair.second}, contacts[i].where.line);
    if (!fresh) {
      tables[i].fail("between", "this contact is declared already in line " + std::to_string(known->second));
    }
  }
}

}  // namespace spindle_twin::fem_offline
