#include "fem_offline/description/read_tables.hpp"
#include "rom/units.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::fem_offline {

using rom::between;
using rom::not_negative;
using rom::positive;

namespace {

constexpr double least_size_mm = 0.01, largest_size_mm = 1000.0;
constexpr rom::Range element_size_mm = between(least_size_mm, largest_size_mm);

/// Elements along the side of a square of the section's area.
constexpr double elements_along = 40.0;
/// Cuts that reach beyond their part do not make the area smaller than this share of the shapes.
constexpr double least_left = 0.1;

double area_mm2(const std::vector<Polygon>& shapes) {
  double sum_m2 = 0.0;
  for (const Polygon& shape : shapes) {
    double twice_m2 = 0.0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const Point &a = shape[i], &b = shape[(i + 1) % shape.size()];
      twice_m2 += a.r_m * b.z_m - b.r_m * a.z_m;
    }
    sum_m2 += 0.5 * std::abs(twice_m2);
  }
  return sum_m2 / (metre_per_mm * metre_per_mm);
}

/// The parts are read once more for it, with arcs as coarse as they get: the real division of the arcs hangs on the
/// size.
double default_size_mm(const TomlTable& root, Geometry geometry) {
  MeshSettings coarse;
  coarse.element_size_m = coarse.arc_sagitta_m = largest_size_mm * metre_per_mm;
  double sum_mm2 = 0.0;
  for (const TomlTable& part : root.tables("part")) {
    part.show_as(part.name());
    part.free_keys();  // the others are asked for, and refused, when the part itself is read
    std::vector<ArcChord> arcs;
    const double shapes_mm2 = area_mm2(read_shapes(part, "rectangles", "polygons", geometry, coarse, arcs));
    const double cuts_mm2 = area_mm2(read_shapes(part, "cut_rectangles", "cut_polygons", geometry, coarse, arcs));
    sum_mm2 += std::max(shapes_mm2 - cuts_mm2, least_left * shapes_mm2);
  }
  return std::clamp(std::sqrt(sum_mm2) / elements_along, least_size_mm, largest_size_mm);
}

}  // namespace

MeshSettings read_mesh(const TomlTable& root, Geometry geometry, double mesh_factor) {
  MeshSettings mesh;
  const auto table = root.optional_table("mesh");
  std::optional<double> size_mm, contact_mm, corner_mm, sagitta_mm;
  if (table) {
    size_mm = table->optional_number("element_size_mm", element_size_mm);
    mesh.degree = static_cast<int>(table->integer_or("degree", 2, 1, 4));
    mesh.cells_across = static_cast<int>(table->integer_or("cells_across", 1, 1, 20));
    mesh.part_time_limit_s = static_cast<int>(table->integer_or("part_time_limit_s", mesh.part_time_limit_s, 1, 3600));
    contact_mm = table->optional_number("contact_element_size_mm", element_size_mm);
    corner_mm = table->optional_number("corner_element_size_mm", element_size_mm);
    mesh.curved_arcs = table->boolean_or("curved_arcs", true);
    sagitta_mm = table->optional_number("arc_sagitta_mm", between(1e-5, 100.0));
  }
  if (!size_mm) size_mm = default_size_mm(root, geometry);
  // A 200th of the element size makes chords of about its length. Twice as many lie a fourth as far from the arc.
  if (!sagitta_mm) sagitta_mm = *size_mm / 200.0;
  mesh.element_size_m = mesh_factor * *size_mm * metre_per_mm;
  if (contact_mm) mesh.contact_size_m = mesh_factor * *contact_mm * metre_per_mm;
  if (corner_mm) mesh.corner_size_m = mesh_factor * *corner_mm * metre_per_mm;
  mesh.arc_sagitta_m = mesh_factor * mesh_factor * *sagitta_mm * metre_per_mm;
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
  part.shapes = read_shapes(table, "rectangles", "polygons", geometry, mesh, part.arcs);
  part.cuts = read_shapes(table, "cut_rectangles", "cut_polygons", geometry, mesh, part.arcs);
  if (const auto size_mm = table.optional_number("element_size_mm", element_size_mm)) {
    part.element_size_m = *size_mm * metre_per_mm;
  }
  if (const auto initial_degC = table.optional_number("initial_degC", temperature_degC)) {
    part.initial_K = *initial_degC + rom::zero_degC_K;
  }
  if (part.shapes.empty()) table.fail("rectangles", "a part needs at least one rectangle or polygon");
  return part;
}

}  // namespace spindle_twin::fem_offline
