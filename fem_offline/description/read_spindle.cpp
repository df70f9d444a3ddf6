#include <fstream>
#include <sstream>

#include "fem_offline/description/read_tables.hpp"
#include "rom/read/sha256.hpp"

namespace spindle_twin::fem_offline {

using rom::InputError;

namespace {

void add_law(const TomlTable& table, LawOwner owner, std::size_t index, const rom::LawDefaults& defaults,
             std::vector<DescribedLaw>& laws) {
  const auto law = table.optional_table("law");
  const rom::LawRole role = owner == LawOwner::heat ? rom::LawRole::heat : rom::LawRole::conductance;
  if (law) laws.push_back({owner, {*law, role, index, defaults}});
}

}  // namespace

Spindle parse_spindle(const std::string& text, const std::string& file, double mesh_factor) {
  const TomlTable root = TomlTable::parse(text, file);
  Spindle spindle;
  spindle.file = file;
  spindle.hash = rom::sha256_hex(text);
  spindle.name = root.name();
  spindle.geometry = root.choice_or("geometry", "axisymmetric", {"axisymmetric", "planar"}) == "planar"
                         ? Geometry::planar
                         : Geometry::axisymmetric;
  spindle.mesh = read_mesh(root, spindle.geometry, mesh_factor);

  Names materials("material"), parts("part"), surroundings("surrounding"), films("film"),
      adiabatics("adiabatic region"), heats("heat"), key_points("key point"), deformations("deformation output");
  for (const auto& table : root.tables("material")) spindle.materials.push_back(read_material(table, materials));
  for (const auto& table : root.tables("part"))
    spindle.parts.push_back(read_part(table, parts, materials, spindle.geometry, spindle.mesh));
  for (Part& part : spindle.parts) {
    if (part.element_size_m) *part.element_size_m *= mesh_factor;
  }
  const auto contacts = root.tables_or_empty("contact");
  for (const auto& table : contacts) spindle.contacts.push_back(read_contact(table, parts, spindle.geometry));
  check_contacts_once(spindle.contacts, contacts);
  std::vector<DescribedLaw> laws;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = spindle.contacts[i];
    add_law(contacts[i], LawOwner::contact, i, {static_cast<int>(contact.part_a), static_cast<int>(contact.part_b)},
            laws);
  }
  for (const auto& table : root.tables("surrounding")) {
    spindle.surroundings.push_back(read_surrounding(table, surroundings));
  }
  for (const auto& table : root.tables_or_empty("film")) {
    spindle.films.push_back(read_film(table, films, surroundings, parts));
    const std::size_t film = spindle.films.size() - 1;
    if (const auto law = table.optional_table("law")) {
      laws.push_back(law_of_film(*law, spindle.films[film], film, spindle));
    }
  }
  for (const auto& table : root.tables_or_empty("prescribed_temperature")) {
    spindle.films.push_back(read_prescribed_temperature(table, films, surroundings, parts));
  }
  for (const auto& table : root.tables_or_empty("radiation")) {
    spindle.films.push_back(read_radiation(table, films, surroundings, parts));
  }
  read_coolant_circuits(root, parts, surroundings, films, spindle, laws);
  // Films and gap films share one list of names because a network addresses both as conductances.
  for (const auto& table : root.tables_or_empty("gap_film")) {
    spindle.gap_films.push_back(read_gap_film(table, films, parts));
    const GapFilm& gap = spindle.gap_films.back();
    add_law(table, LawOwner::gap_film, spindle.gap_films.size() - 1,
            {static_cast<int>(gap.part_a), static_cast<int>(gap.part_b)}, laws);
  }
  for (const auto& table : root.tables_or_empty("adiabatic")) {
    Adiabatic adiabatic;
    adiabatic.name = adiabatics.add(table);
    adiabatic.where = table.where("name");
    adiabatic.regions = read_regions(table);
    spindle.adiabatics.push_back(std::move(adiabatic));
  }
  for (const auto& table : root.tables_or_empty("heat")) {
    spindle.heats.push_back(read_heat(table, heats, parts));
    add_law(table, LawOwner::heat, spindle.heats.size() - 1, {}, laws);
  }
  for (const auto& table : root.tables_or_empty("support")) {
    spindle.supports.push_back(read_support(table, parts, spindle.geometry));
  }
  for (const auto& table : root.tables_or_empty("key_point")) {
    const std::string name = key_points.add(table);
    const std::size_t part = parts.find(table, "part");
    const auto at_mm = table.numbers("at", 2, coordinate_mm(spindle.geometry));
    spindle.key_points.push_back({name, part, {at_mm[0] * metre_per_mm, at_mm[1] * metre_per_mm}, table.where("name")});
  }
  for (const auto& table : root.tables_or_empty("deformation")) {
    spindle.deformations.push_back(read_deformation(table, deformations, parts, spindle.geometry));
  }
  read_mechanics(root, parts, spindle);
  spindle.operating = read_operating(root.table("operating"), spindle.surroundings, surroundings);
  set_prescribed_coefficients(spindle);
  read_laws(laws, spindle);
  read_verification(root, spindle);
  root.finish();
  return spindle;
}

Spindle read_spindle(const std::string& path, double mesh_factor) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw InputError({path, 0}, "", "cannot be read as a file");
  return parse_spindle(text.str(), path, mesh_factor);
}

}  // namespace spindle_twin::fem_offline
