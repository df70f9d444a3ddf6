#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "rom/read/strict_toml.hpp"

/// The pieces of read_spindle, one function per table of the description. All throw rom::InputError.
namespace spindle_twin::fem_offline {

using rom::TomlTable;

inline constexpr double metre_per_mm = 1e-3;
inline constexpr double metre_per_um = 1e-6;
inline constexpr double kelvin_at_0_degC = 273.15;
inline constexpr rom::Range length_mm{0.0, 1e5, false, false};

/// Range of a coordinate of a part or point.
inline rom::Range coordinate_mm(Geometry geometry) {
  return geometry == Geometry::planar ? rom::between(-1e5, 1e5) : length_mm;
}
inline constexpr rom::Range temperature_degC{-273.15, 1000.0, true, false};

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

Box box_from(const TomlTable& table, const std::string& key, const std::vector<double>& row_mm, bool may_be_flat);
std::vector<Polygon> read_shapes(const TomlTable& table, const std::string& rectangles, const std::string& polygons,
                                 Geometry geometry, const MeshSettings& mesh, std::vector<ArcChord>& arcs);
/// Corners of a polygon; arcs become chords no further from the arc than the sagitta and no longer than two elements,
/// each of which is added to `arcs`.
Polygon read_polygon(const TomlTable& table, Geometry geometry, const MeshSettings& mesh, std::vector<ArcChord>& arcs);
/// Without an element size in the file it follows from the area of the parts.
MeshSettings read_mesh(const TomlTable& root, Geometry geometry, double mesh_factor);
std::vector<Box> read_regions(const TomlTable& table);
Box read_face(const TomlTable& table, const std::string& key);
rom::SpeedLaw read_speed_law(const TomlTable& owner);

Material read_material(const TomlTable& table, Names& names);
Part read_part(const TomlTable& table, Names& names, const Names& materials, Geometry geometry,
               const MeshSettings& mesh);
Contact read_contact(const TomlTable& table, const Names& parts, Geometry geometry);
void check_contacts_once(const std::vector<Contact>& contacts, const std::vector<TomlTable>& tables);

Surrounding read_surrounding(const TomlTable& table, Names& names);
Film read_film(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts);
Film read_prescribed_temperature(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts);
Film read_radiation(const TomlTable& table, Names& names, const Names& surroundings, const Names& parts);
/// Gives every prescribed temperature its coefficient, once materials, parts and mesh are known.
void set_prescribed_coefficients(Spindle& spindle);
/// [[coolant_circuit]], whose segments join the films.
void read_coolant_circuits(const TomlTable& root, const Names& parts, const Names& surroundings, Names& films,
                           Spindle& spindle);
GapFilm read_gap_film(const TomlTable& table, Names& names, const Names& parts);
HeatSource read_heat(const TomlTable& table, Names& names, const Names& parts);
Operating read_operating(const TomlTable& table, const std::vector<Surrounding>& surroundings, const Names& names);

/// [verification] and [[expect]]; needs everything else of the description.
void read_verification(const TomlTable& root, Spindle& spindle);

Support read_support(const TomlTable& table, const Names& parts, Geometry geometry);
DeformationOutput read_deformation(const TomlTable& table, Names& names, const Names& parts, Geometry geometry);
/// [[contact_pressure]], [[stress_probe]] and [imposed_temperature], once contacts and supports are known; also checks
/// that a support holds whatever asks for mechanics.
void read_mechanics(const TomlTable& root, const Names& parts, Spindle& spindle);

}  // namespace spindle_twin::fem_offline
