#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "rom/read/names.hpp"
#include "rom/read/strict_toml.hpp"
#include "rom/read_laws/read_physical_law.hpp"
#include "rom/read_laws/read_speed_law.hpp"
#include "rom/units.hpp"

/// The pieces of read_spindle, one function per table of the description. All throw rom::InputError.
namespace spindle_twin::fem_offline {

using rom::Names;
using rom::read_speed_law;
using rom::TomlTable;

inline constexpr double metre_per_mm = 1e-3;
inline constexpr rom::Range length_mm{0.0, 1e5, false, false};

/// Range of a coordinate of a part or point.
inline rom::Range coordinate_mm(Geometry geometry) {
  return geometry == Geometry::planar ? rom::between(-1e5, 1e5) : length_mm;
}
using rom::temperature_degC;

/// Whose law it is; pending.index: its place in the spindle's list of these.
enum class LawOwner { heat, contact, gap_film, film };
struct DescribedLaw {
  LawOwner owner = LawOwner::heat;
  rom::PendingLaw pending;
};

/// A description that is being read: what stands in it so far, and the names that tables below may use.
struct Reading {
  Spindle spindle;
  std::vector<DescribedLaw> laws;  ///< read last, when all that they may name is known
  Names materials{"material"};
  Names parts{"part"};
  Names surroundings{"surrounding"};
  Names films{"film"};  ///< gap films too, because a network addresses both as conductances
  Names circuits{"coolant circuit"};
  Names adiabatics{"adiabatic region"};
  Names heats{"heat"};
  Names key_points{"key point"};
  Names deformations{"deformation output"};
};

/// Keeps the table `law` of an item for later, if it has one; `index` is the item's place in the spindle's list.
void keep_law(const TomlTable& table, LawOwner owner, std::size_t index, const rom::LawDefaults& defaults,
              Reading& into);

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

Material read_material(const TomlTable& table, Names& names);
Part read_part(const TomlTable& table, Names& names, const Names& materials, Geometry geometry,
               const MeshSettings& mesh);
Surrounding read_surrounding(const TomlTable& table, Names& names);
/// Gives every prescribed temperature its coefficient, once materials, parts and mesh are known.
void set_prescribed_coefficients(Spindle& spindle);

// Readers of the rows of face_conditions: each adds one table to the description.
void read_contact(const TomlTable& table, Reading& into);
/// Its segments join the films.
void read_coolant_circuit(const TomlTable& table, Reading& into);
void read_gap_film(const TomlTable& table, Reading& into);
void read_heat(const TomlTable& table, Reading& into);

Operating read_operating(const TomlTable& table, const std::vector<Surrounding>& surroundings, const Names& names);

/// The law of spindle.films[film_index], which is `film`.
DescribedLaw law_of_film(const TomlTable& law, const Film& film, std::size_t film_index, const Spindle& spindle);

/// The tables `law`, once all that they may name is known: each becomes the `physics` of its item and gives its nominal
/// value.
void read_laws(const std::vector<DescribedLaw>& laws, Spindle& spindle);

/// [verification] and [[expect]]; needs everything else of the description.
void read_verification(const TomlTable& root, Spindle& spindle);

Support read_support(const TomlTable& table, const Names& parts, Geometry geometry);
DeformationOutput read_deformation(const TomlTable& table, Names& names, const Names& parts, Geometry geometry);
/// [[contact_pressure]], [[stress_probe]] and [imposed_temperature], once contacts and supports are known; also checks
/// that a support holds whatever asks for mechanics.
void read_mechanics(const TomlTable& root, const Names& parts, Spindle& spindle);

}  // namespace spindle_twin::fem_offline
