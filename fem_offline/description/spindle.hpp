#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/read/input_error.hpp"

/// The plain data of a spindle description, SI and kelvin. Every item remembers the line it came from,
/// so that an error found later (geometry, mesh) still names file and line.
namespace spindle_twin::fem_offline {

/// A body of revolution about z, or a planar body of which everything (volume, area, heat) counts per metre of depth; a
/// planar one reads r, z as x, y, each of any sign.
enum class Geometry { axisymmetric, planar };

/// Volume per area of the section: 2πr, or 1 when planar. [m]
inline double depth_m(Geometry geometry, double r_m) {
  return geometry == Geometry::planar ? 1.0 : 2.0 * std::numbers::pi * r_m;
}

struct Point {
  double r_m = 0.0;
  double z_m = 0.0;
};

/// r0 <= r1, z0 <= z1; degenerate in one direction where it selects a face.
struct Box {
  double r0_m = 0.0, r1_m = 0.0, z0_m = 0.0, z1_m = 0.0;
};

using Polygon = std::vector<Point>;

/// A side of a polygon that stands for an arc about `centre`, of less than half a circle.
struct ArcChord {
  Point start, end, centre;
};

struct Material {
  std::string name;
  double conductivity_r_W_per_mK = 0.0;
  double conductivity_z_W_per_mK = 0.0;
  double density_kg_per_m3 = 0.0;
  double heat_capacity_J_per_kgK = 0.0;
  double youngs_modulus_Pa = 0.0;
  double poisson_ratio = 0.0;
  double expansion_per_K = 0.0;
  rom::SourceLine where;
};

/// Union of shapes minus cuts.
struct Part {
  std::string name;
  std::size_t material = 0;
  std::vector<Polygon> shapes;  ///< rectangles are polygons of four points
  std::vector<Polygon> cuts;
  std::vector<ArcChord> arcs;            ///< the sides of shapes and cuts that are arcs
  std::optional<double> element_size_m;  ///< in place of the one of the mesh
  std::optional<double> initial_K;       ///< where a transient starts; else with the rest of the spindle
  rom::SourceLine where;
};

/// Interference fit of part_a (inner body, bore inner_radius) in part_b (outer body, outside outer_radius).
struct InterferenceFit {
  double inner_radius_m = 0.0;
  double fit_radius_m = 0.0;
  double outer_radius_m = 0.0;
  double interference_m = 0.0;  ///< radial, at assembly
};

struct Contact {
  std::size_t part_a = 0;
  std::size_t part_b = 0;
  double conductance_W_per_m2K = 0.0;
  std::optional<InterferenceFit> fit;
  std::optional<double> preload_pressure_Pa;  ///< of a bolted or clamped joint, at assembly
  rom::SourceLine where;
  std::optional<rom::BoundLaw> physics = {};  ///< whose nominal value the conductance is
};

enum class SurroundingKind { ambient, coolant, air };

/// Ambient and coolant are inputs; air is a well-mixed volume with its own temperature.
struct Surrounding {
  std::string name;
  SurroundingKind kind = SurroundingKind::ambient;
  double capacity_J_per_K = 0.0;  ///< air only
  rom::SourceLine where;
};

struct FaceCondition;

/// The condition of a [[film]] (description/face_conditions).
const FaceCondition* plain_film();

/// Film on every exposed face whose outward side lies in one of the regions (and, if `only_parts` is not
/// empty, belongs to one of those parts). Whatever exchanges heat with a surrounding is one: a prescribed temperature
/// is a film so good that the wall takes the surrounding's temperature, radiation one of 4 ε σ T³.
struct Film {
  std::string name;
  const FaceCondition* condition = plain_film();  ///< never null: which [[table]] it comes from
  double coefficient_W_per_m2K = 0.0;
  std::size_t surrounding = 0;
  std::vector<Box> regions;
  std::vector<std::size_t> only_parts;
  rom::SpeedLaw law;
  rom::SourceLine where;
  std::optional<rom::BoundLaw> physics = {};  ///< whose nominal value stands above
};

/// A channel that coolant passes from segment to segment, warming up on the way (rom::CoolantCircuit). Its segments are
/// films of `Spindle::films`, each with its own film coefficient.
struct CoolantCircuit {
  std::string name;
  std::size_t inlet = 0;       ///< a surrounding of kind coolant
  double flow_kg_per_s = 0.0;  ///< at the reference state; negative: from the last segment to the first
  double heat_capacity_J_per_kgK = 0.0;
  std::vector<std::size_t> segments;  ///< films in the order of positive flow
  rom::SourceLine where;
};

/// Wall-to-wall film across a narrow gap between two parallel faces; area counted at the mean radius.
struct GapFilm {
  std::string name;
  double coefficient_W_per_m2K = 0.0;  ///< wall to wall
  std::size_t part_a = 0;
  std::size_t part_b = 0;
  Box region;  ///< the void between the two faces
  rom::SpeedLaw law;
  rom::SourceLine where;
  std::optional<rom::BoundLaw> physics = {};  ///< whose nominal value stands above
};

/// Exposed faces whose outward side lies in a region and that carry no heat.
struct Adiabatic {
  std::string name;
  std::vector<Box> regions;
  rom::SourceLine where;
};

/// One place where a heat source acts: the volume of `part`, its faces towards `on_contact_with`, or its exposed faces
/// inside `on_face` (which carry a film or are adiabatic besides). Spread evenly over that volume or area.
struct HeatShare {
  std::size_t part = 0;
  std::optional<std::size_t> on_contact_with;
  std::optional<Box> on_face;
  double weight = 1.0;  ///< see HeatSource
};

/// Either heat_W is given and the weights are shares that sum to 1, or density_W_per_m3 with `density_over` parts
/// (heat_W = density · their volume, weights are shares that sum to 1), or density_W_per_m3 alone, where every
/// share is a volume and its weight multiplies the density, or flux_W_per_m2, where every share is a face and its
/// weight multiplies the flux.
struct HeatSource {
  std::string name;
  std::optional<double> heat_W;
  std::optional<double> density_W_per_m3;
  std::optional<double> flux_W_per_m2;
  std::vector<std::size_t> density_over;
  std::vector<HeatShare> shares;
  rom::SpeedLaw law;
  rom::SourceLine where;
  std::optional<rom::BoundLaw> physics = {};  ///< whose nominal value stands above
  bool friction = false;                      ///< as in rom::HeatSource
};

/// What holds a component of displacement: u = 0, a spring to the ground, or for `plane` all values on the face equal,
/// whatever they are (generalised plane strain).
enum class Hold { free, fixed, spring, plane };

/// Acts on the boundary of `part` inside `face`, or on one point of its outline, where `face` is that point. A spring's
/// stiffness is that of the whole face (of the whole circle through the point, per metre of depth when planar).
struct Support {
  std::size_t part = 0;
  Box face;
  rom::SourceLine where;
  Hold hold_r = Hold::free;
  Hold hold_z = Hold::fixed;
  double stiffness_r_N_per_m = 0.0;
  double stiffness_z_N_per_m = 0.0;

  bool is_point() const { return face.r0_m == face.r1_m && face.z0_m == face.z1_m; }
};

struct KeyPoint {
  std::string name;
  std::size_t part = 0;
  Point at;
  rom::SourceLine where;
};

enum class Direction { axial, radial };

/// Mean displacement (weighted by r) of the faces of `part` inside `face`, or displacement of the point `at` of it,
/// times `sign`, less the earlier output `minus`.
struct DeformationOutput {
  std::string name;
  std::size_t part = 0;
  Box face;
  Direction direction = Direction::axial;
  double sign = 1.0;
  rom::SourceLine where;
  std::optional<Point> at;           ///< instead of `face`
  std::optional<std::size_t> minus;  ///< index of an earlier output
};

/// Mean pressure of a contact. Joints with a fit or a preload have one without asking.
struct ContactPressureOutput {
  std::string name;
  std::size_t contact = 0;
  rom::SourceLine where;
};

struct StressProbe {
  std::string name;
  std::size_t part = 0;
  Point at;
  rom::SourceLine where;
};

/// Rise above the reference temperature as a formula in r, z (m) and r_mm, z_mm; conduction is not solved then.
struct ImposedTemperature {
  std::string rise_K;
  rom::SourceLine where;
};

struct Operating {
  double speed_rpm = 0.0;
  double load = 1.0;
  double reference_temperature_K = 0.0;
  std::vector<double> surrounding_K;  ///< one per surrounding; unused for air
  rom::SourceLine where;              ///< of the reference temperature
};

/// One figure that a description with a known answer must give; what `spindle-twin verify-fem` compares.
struct Expectation {
  std::string quantity;          ///< the value's kind, with its unit
  std::string of;                ///< name of the key point, output, film or contact it is read from
  std::optional<double> time_s;  ///< along the schedule; steady without it
  double target = 0.0;           ///< in the unit of `quantity`
  double tolerance = 0.0;        ///< fraction of the temperature span for temperatures, else of the target
  std::string source;
  rom::SourceLine where;
};

/// What makes a description a verification case.
struct Verification {
  std::string proves;
  double temperature_span_K = 0.0;
  std::string schedule;     ///< CSV beside the description; empty = the operating state held
  double max_step_s = 1.0;  ///< of the transient
  std::vector<Expectation> expectations;
};

struct MeshSettings {
  double element_size_m = 0.004;  ///< without one in the file: √(area of the section) / 40
  int degree = 2;
  int part_time_limit_s = 10;            ///< computing that gmsh may take for one part
  int cells_across = 1;                  ///< least number of elements across the thickness of any part
  std::optional<double> contact_size_m;  ///< element size where parts touch
  std::optional<double> corner_size_m;   ///< element size at corners that go into the material (mesh/sharp_places)
  int halvings = 0;                      ///< times that every element is cut in four after all else; in no file
  double arc_sagitta_m = 2e-5;           ///< furthest distance of an arc from its chord
  bool curved_arcs = true;               ///< sides of elements follow the arcs; else the chords
};

struct Spindle {  // NOLINT(public-members): the description as read, a member for each of its tables
  std::string name;
  std::string file;
  std::string hash;  ///< SHA-256 of the file, hex
  Geometry geometry = Geometry::axisymmetric;
  std::vector<Material> materials;
  std::vector<Part> parts;
  std::vector<Contact> contacts;
  std::vector<Surrounding> surroundings;
  std::vector<Film> films;
  std::vector<CoolantCircuit> circuits;
  std::vector<GapFilm> gap_films;
  std::vector<Adiabatic> adiabatics;
  std::vector<HeatSource> heats;
  std::vector<Support> supports;
  std::vector<KeyPoint> key_points;
  std::vector<DeformationOutput> deformations;
  std::vector<ContactPressureOutput> contact_pressures;
  std::vector<StressProbe> stress_probes;
  std::optional<ImposedTemperature> imposed_temperature;
  Operating operating;
  std::vector<rom::PlausibleRange> plausible;
  MeshSettings mesh;
  std::optional<Verification> verification;
};

/// Reads a TOML description (lengths in mm, temperatures in degC, everything else SI).
/// Throws rom::InputError with file, line and names for an unknown key, a missing or doubled name, an
/// unknown reference, a negative, out-of-range or non-finite value. `mesh_factor` (> 0) multiplies all element sizes,
/// chords of arcs among them.
Spindle read_spindle(const std::string& path, double mesh_factor = 1.0);

/// The same from text; `file` is only for messages.
Spindle parse_spindle(const std::string& text, const std::string& file, double mesh_factor = 1.0);

}  // namespace spindle_twin::fem_offline
