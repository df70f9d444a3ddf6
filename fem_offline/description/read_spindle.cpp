#include <fstream>
#include <sstream>

#include "fem_offline/description/face_conditions.hpp"
#include "fem_offline/description/read_tables.hpp"
#include "rom/read/sha256.hpp"
#include "rom/read_laws/read_plausible.hpp"

namespace spindle_twin::fem_offline {

using rom::InputError;

namespace {

/// Materials and parts.
void read_bodies(const TomlTable& root, double mesh_factor, Reading& into) {
  Spindle& spindle = into.spindle;
  for (const auto& table : root.tables("material")) spindle.materials.push_back(read_material(table, into.materials));
  for (const auto& table : root.tables("part")) {
    spindle.parts.push_back(read_part(table, into.parts, into.materials, spindle.geometry, spindle.mesh));
    if (auto& size_m = spindle.parts.back().element_size_m) *size_m *= mesh_factor;
  }
}

/// Surroundings and all that happens at faces; heats in volumes too.
void read_conditions(const TomlTable& root, Reading& into) {
  for (const auto& table : root.tables("surrounding")) {
    into.spindle.surroundings.push_back(read_surrounding(table, into.surroundings));
  }
  for (const FaceCondition& condition : face_conditions()) {
    for (const auto& table : root.tables_or_empty(std::string(condition.table))) condition.read(table, into);
  }
}

/// What is asked of the spindle, and what holds it.
void read_outputs(const TomlTable& root, Reading& into) {
  Spindle& spindle = into.spindle;
  for (const auto& table : root.tables_or_empty("support")) {
    spindle.supports.push_back(read_support(table, into.parts, spindle.geometry));
  }
  for (const auto& table : root.tables_or_empty("key_point")) {
    const std::string name = into.key_points.add(table);
    const std::size_t part = into.parts.find(table, "part");
    const auto at_mm = table.numbers("at", 2, coordinate_mm(spindle.geometry));
    spindle.key_points.push_back({name, part, {at_mm[0] * metre_per_mm, at_mm[1] * metre_per_mm}, table.where("name")});
  }
  for (const auto& table : root.tables_or_empty("deformation")) {
    spindle.deformations.push_back(read_deformation(table, into.deformations, into.parts, spindle.geometry));
  }
  read_mechanics(root, into.parts, spindle);
}

/// [plausible]: of ambients and coolants, and of circuits.
std::vector<rom::PlausibleRange> read_plausible(const TomlTable& root, const Spindle& spindle) {
  std::vector<std::string> environments, circuits;
  for (const Surrounding& surrounding : spindle.surroundings) {
    if (surrounding.kind != SurroundingKind::air) environments.push_back(surrounding.name);
  }
  for (const CoolantCircuit& circuit : spindle.circuits) circuits.push_back(circuit.name);
  return rom::read_plausible(root, environments, circuits);
}

}  // namespace

void keep_law(const TomlTable& table, LawOwner owner, std::size_t index, const rom::LawDefaults& defaults,
              Reading& into) {
  const rom::LawRole role = owner == LawOwner::heat ? rom::LawRole::heat : rom::LawRole::conductance;
  if (const auto law = table.optional_table("law")) into.laws.push_back({owner, {*law, role, index, defaults}});
}

Spindle parse_spindle(const std::string& text, const std::string& file, double mesh_factor) {
  const TomlTable root = TomlTable::parse(text, file);
  Reading into;
  Spindle& spindle = into.spindle;
  spindle.file = file;
  spindle.hash = rom::sha256_hex(text);
  spindle.name = root.name();
  spindle.geometry = root.choice_or("geometry", "axisymmetric", {"axisymmetric", "planar"}) == "planar"
                         ? Geometry::planar
                         : Geometry::axisymmetric;
  spindle.mesh = read_mesh(root, spindle.geometry, mesh_factor);
  read_bodies(root, mesh_factor, into);
  read_conditions(root, into);
  read_outputs(root, into);
  spindle.operating = read_operating(root.table("operating"), spindle.surroundings, into.surroundings);
  spindle.plausible = read_plausible(root, spindle);
  set_prescribed_coefficients(spindle);
  read_laws(into.laws, spindle);
  read_verification(root, spindle);
  root.finish();
  return std::move(into.spindle);
}

Spindle read_spindle(const std::string& path, double mesh_factor) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream && stream.peek() == std::ifstream::traits_type::eof() && !stream.bad()) {
    throw InputError({path, 0}, "", "is empty; a description of a spindle is needed");
  }
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw InputError({path, 0}, "", "cannot be read as a file");
  return parse_spindle(text.str(), path, mesh_factor);
}

}  // namespace spindle_twin::fem_offline
