#include <sodium.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "fem_offline/description/spindle.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::fem_offline {
namespace {

using rom::any_number;
using rom::between;
using rom::InputError;
using rom::not_negative;
using rom::positive;
using rom::TomlTable;

constexpr double metre_per_mm = 1e-3;
constexpr double metre_per_um = 1e-6;
constexpr double kelvin_at_0_degC = 273.15;
constexpr rom::Range length_mm{0.0, 1e5, false, false};
constexpr rom::Range temperature_degC{-273.15, 1000.0, true, false};

/// The names given so far in one list, each with its place in the list.
class Names {
 public:
  explicit Names(std::string kind) : kind_(std::move(kind)) {}

  std::string add(const TomlTable& table) {
    const std::string name = table.name();
    table.show_as(name);
    const auto [known, fresh] = places_.try_emplace(name, Entry{places_.size(), table.where("name").line});
    if (!fresh) {
      table.fail("name", "the name \"" + name + "\" is taken by the " + kind_ + " of line " +
                             std::to_string(known->second.line));
    }
    return name;
  }

  std::size_t find(const TomlTable& table, const std::string& key, const std::string& name) const {
    const auto known = places_.find(name);
    if (known != places_.end()) return known->second.place;
    std::string all;
    for (const auto& [other, entry] : places_) all += (all.empty() ? "" : ", ") + other;
    table.fail(key, "there is no " + kind_ + " \"" + name + "\"; there are: " + (all.empty() ? "none" : all));
  }

  std::size_t find(const TomlTable& table, const std::string& key) const { return find(table, key, table.string(key)); }

  std::vector<std::size_t> find_all(const TomlTable& table, const std::string& key,
                                    const std::vector<std::string>& names) const {
    std::vector<std::size_t> found;
    for (const auto& name : names) {
      const std::size_t place = find(table, key, name);
      if (std::find(found.begin(), found.end(), place) != found.end()) {
        table.fail(key, "\"" + name + "\" is listed twice");
      }
      found.push_back(place);
    }
    return found;
  }

  std::pair<std::size_t, std::size_t> find_pair(const TomlTable& table, const std::string& key) const {
    const auto names = table.strings(key);
    if (names.size() != 2) table.fail(key, "must be the names of two different parts");
    const auto both = find_all(table, key, names);
    return {both[0], both[1]};
  }

 private:
  struct Entry {
    std::size_t place;
    int line;
  };
  std::string kind_;
  std::map<std::string, Entry> places_;
};

Box box_from(const TomlTable& table, const std::string& key, const std::vector<double>& row_mm, bool may_be_flat) {
  const Box box{row_mm[0] * metre_per_mm, row_mm[1] * metre_per_mm, row_mm[2] * metre_per_mm, row_mm[3] * metre_per_mm};
  const bool ordered =
      may_be_flat ? box.r0_m <= box.r1_m && box.z0_m <= box.z1_m && (box.r0_m < box.r1_m || box.z0_m < box.z1_m)
                  : box.r0_m < box.r1_m && box.z0_m < box.z1_m;
  if (!ordered) {
    std::ostringstream text;
    text << "[" << row_mm[0] << ", " << row_mm[1] << ", " << row_mm[2] << ", " << row_mm[3]
         << "] must be [r0, r1, z0, z1] with "
         << (may_be_flat ? "r0 <= r1, z0 <= z1 and not a single point" : "r0 < r1 and z0 < z1");
    table.fail(key, text.str());
  }
  return box;
}

std::vector<Box> read_boxes(const TomlTable& table, const std::string& key) {
  std::vector<Box> boxes;
  for (const auto& row : table.rows_or_empty(key, 4, any_number)) boxes.push_back(box_from(table, key, row, false));
  return boxes;
}

std::vector<Box> read_regions(const TomlTable& table) {
  auto boxes = read_boxes(table, "regions");
  if (boxes.empty()) table.fail("regions", "must hold at least one [r0, r1, z0, z1]");
  return boxes;
}

Box read_face(const TomlTable& table, const std::string& key) {
  return box_from(table, key, table.numbers(key, 4, any_number), true);
}

std::vector<Polygon> read_shapes(const TomlTable& table, const std::string& rectangles, const std::string& polygons) {
  std::vector<Polygon> shapes;
  for (const auto& row : table.rows_or_empty(rectangles, 4, length_mm)) {
    const Box box = box_from(table, rectangles, row, false);
    shapes.push_back({{box.r0_m, box.z0_m}, {box.r1_m, box.z0_m}, {box.r1_m, box.z1_m}, {box.r0_m, box.z1_m}});
  }
  for (const auto& polygon : table.tables_or_empty(polygons)) {
    Polygon shape;
    for (const auto& row : polygon.rows_or_empty("points", 2, length_mm)) {
      shape.push_back({row[0] * metre_per_mm, row[1] * metre_per_mm});
    }
    if (shape.size() < 3) polygon.fail("points", "must hold at least three [r, z]");
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

rom::SpeedLaw read_speed_law(const TomlTable& owner) {
  rom::SpeedLaw law;
  const auto table = owner.optional_table("speed_law");
  if (!table) return law;
  law.constant = table->number_or("constant", 0.0, not_negative);
  for (const auto& row : table->rows_or_empty("speed_terms", 2, not_negative))
    law.speed_terms.push_back({row[0], row[1]});
  law.load_squared = table->number_or("load_squared", 0.0, not_negative);
  law.zero_at_standstill = table->boolean_or("zero_at_standstill", false);
  double sum = law.constant + law.load_squared;
  for (const auto& term : law.speed_terms) sum += term.coefficient;
  if (std::abs(sum - 1.0) > 1e-9) {
    std::ostringstream text;
    text << "constant, coefficients and load_squared must add up to 1, the value at reference speed and full load; "
            "they make "
         << sum;
    owner.fail("speed_law", text.str());
  }
  return law;
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

Part read_part(const TomlTable& table, Names& names, const Names& materials) {
  Part part;
  part.name = names.add(table);
  part.where = table.where("name");
  part.material = materials.find(table, "material");
  part.shapes = read_shapes(table, "rectangles", "polygons");
  part.cuts = read_shapes(table, "cut_rectangles", "cut_polygons");
  if (part.shapes.empty()) table.fail("rectangles", "a part needs at least one rectangle or polygon");
  return part;
}

Contact read_contact(const TomlTable& table, const Names& parts) {
  Contact contact;
  contact.where = table.where("between");
  const auto names = table.strings("between");
  if (names.size() == 2) table.show_as(names[0] + "-" + names[1]);
  std::tie(contact.part_a, contact.part_b) = parts.find_pair(table, "between");
  contact.conductance_W_per_m2K = table.number("conductance_W_per_m2K", positive);
  if (const auto fit = table.optional_table("interference_fit")) {
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
  return contact;
}

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

DeformationOutput read_deformation(const TomlTable& table, Names& names, const Names& parts) {
  DeformationOutput output;
  output.name = names.add(table);
  output.where = table.where("name");
  output.part = parts.find(table, "part");
  output.face = read_face(table, "face");
  const std::string positive_along = table.choice("positive_along", {"+z", "-z", "+r", "-r"});
  output.sign = positive_along[0] == '+' ? 1.0 : -1.0;
  output.direction = positive_along[1] == 'z' ? Direction::axial : Direction::radial;
  return output;
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

std::string sha256_hex(const std::string& text) {
  unsigned char digest[crypto_hash_sha256_BYTES];
  crypto_hash_sha256(digest, reinterpret_cast<const unsigned char*>(text.data()), text.size());
  char hex[2 * sizeof digest + 1];
  return sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
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

}  // namespace

Spindle parse_spindle(const std::string& text, const std::string& file) {
  const TomlTable root = TomlTable::parse(text, file);
  Spindle spindle;
  spindle.file = file;
  spindle.hash = sha256_hex(text);
  spindle.name = root.name();

  Names materials("material"), parts("part"), surroundings("surrounding"), films("film"),
      adiabatics("adiabatic region"), heats("heat"), key_points("key point"), deformations("deformation output");
  for (const auto& table : root.tables("material")) spindle.materials.push_back(read_material(table, materials));
  for (const auto& table : root.tables("part")) spindle.parts.push_back(read_part(table, parts, materials));
  const auto contacts = root.tables_or_empty("contact");
  for (const auto& table : contacts) spindle.contacts.push_back(read_contact(table, parts));
  check_contacts_once(spindle.contacts, contacts);
  for (const auto& table : root.tables("surrounding")) {
    spindle.surroundings.push_back(read_surrounding(table, surroundings));
  }
  for (const auto& table : root.tables_or_empty("film")) {
    spindle.films.push_back(read_film(table, films, surroundings, parts));
  }
  // Films and gap films share one list of names because a network addresses both as conductances.
  for (const auto& table : root.tables_or_empty("gap_film")) {
    spindle.gap_films.push_back(read_gap_film(table, films, parts));
  }
  for (const auto& table : root.tables_or_empty("adiabatic")) {
    Adiabatic adiabatic;
    adiabatic.name = adiabatics.add(table);
    adiabatic.where = table.where("name");
    adiabatic.regions = read_regions(table);
    spindle.adiabatics.push_back(std::move(adiabatic));
  }
  for (const auto& table : root.tables_or_empty("heat")) spindle.heats.push_back(read_heat(table, heats, parts));
  for (const auto& table : root.tables_or_empty("support")) {
    spindle.supports.push_back({parts.find(table, "part"), read_face(table, "face"), table.where("face")});
  }
  for (const auto& table : root.tables_or_empty("key_point")) {
    const std::string name = key_points.add(table);
    const std::size_t part = parts.find(table, "part");
    const auto at_mm = table.numbers("at", 2, not_negative);
    spindle.key_points.push_back({name, part, {at_mm[0] * metre_per_mm, at_mm[1] * metre_per_mm}, table.where("name")});
  }
  for (const auto& table : root.tables_or_empty("deformation")) {
    spindle.deformations.push_back(read_deformation(table, deformations, parts));
  }
  if (!spindle.deformations.empty() && spindle.supports.empty()) {
    root.fail("deformation", "a deformation output needs a support that holds the spindle");
  }
  spindle.operating = read_operating(root.table("operating"), spindle.surroundings, surroundings);
  if (const auto mesh = root.optional_table("mesh")) {
    spindle.mesh.element_size_m = mesh->number_or("element_size_mm", 4.0, {0.01, 1000.0, false, false}) * metre_per_mm;
    spindle.mesh.degree = static_cast<int>(mesh->integer_or("degree", 2, 1, 4));
  }
  root.finish();
  return spindle;
}

Spindle read_spindle(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw InputError({path, 0}, "", "cannot be read as a file");
  return parse_spindle(text.str(), path);
}

}  // namespace spindle_twin::fem_offline
