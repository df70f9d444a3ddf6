#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/read/input_error.hpp"

/// The plain data of a spindle description, SI and kelvin. Every item remembers the line it came from,
/// so that an error found later (geometry, mesh) still names file and line.
namespace spindle_twin::fem_offline {

struct Point {
  double r_m = 0.0;
  double z_m = 0.0;
};

/// r0 <= r1, z0 <= z1; degenerate in one direction where it selects a face.
struct Box {
  double r0_m = 0.0, r1_m = 0.0, z0_m = 0.0, z1_m = 0.0;
};

using Polygon = std::vector<Point>;

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
  rom::SourceLine where;
};

enum class SurroundingKind { ambient, coolant, air };

/// Ambient and coolant are inputs; air is a well-mixed volume with its own temperature.
struct Surrounding {
  std::string name;
  SurroundingKind kind = SurroundingKind::ambient;
  double capacity_J_per_K = 0.0;  ///< air only
  rom::SourceLine where;
};

/// Film on every exposed face whose outward side lies in one of the regions (and, if `only_parts` is not
/// empty, belongs to one of those parts).
struct Film {
  std::string name;
  double coefficient_W_per_m2K = 0.0;
  std::size_t surrounding = 0;
  std::vector<Box> regions;
  std::vector<std::size_t> only_parts;
  rom::SpeedLaw law;
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
/// share is a volume and its weight multiplies the density.
struct HeatSource {
  std::string name;
  std::optional<double> heat_W;
  std::optional<double> density_W_per_m3;
  std::vector<std::size_t> density_over;
  std::vector<HeatShare> shares;
  rom::SpeedLaw law;
  rom::SourceLine where;
};

/// u_z = 0 on the nodes of `part` that lie on its boundary inside `face`.
struct Support {
  std::size_t part = 0;
  Box face;
  rom::SourceLine where;
};

struct KeyPoint {
  std::string name;
  std::size_t part = 0;
  Point at;
  rom::SourceLine where;
};

enum class Direction { axial, radial };

/// Mean displacement (weighted by r) of the faces of `part` inside `face`, times `sign`.
struct DeformationOutput {
  std::string name;
  std::size_t part = 0;
  Box face;
  Direction direction = Direction::axial;
  double sign = 1.0;
  rom::SourceLine where;
};

struct Operating {
  double speed_rpm = 0.0;
  double load = 1.0;
  double reference_temperature_K = 0.0;
  std::vector<double> surrounding_K;  ///< one per surrounding; unused for air
};

struct MeshSettings {
  double element_size_m = 0.004;
  int degree = 2;
};

struct Spindle {
  std::string name;
  std::string file;
  std::string hash;  ///< SHA-256 of the file, hex
  std::vector<Material> materials;
  std::vector<Part> parts;
  std::vector<Contact> contacts;
  std::vector<Surrounding> surroundings;
  std::vector<Film> films;
  std::vector<GapFilm> gap_films;
  std::vector<Adiabatic> adiabatics;
  std::vector<HeatSource> heats;
  std::vector<Support> supports;
  std::vector<KeyPoint> key_points;
  std::vector<DeformationOutput> deformations;
  Operating operating;
  MeshSettings mesh;
};

/// Reads a TOML description (lengths in mm, temperatures in degC, everything else SI).
/// Throws rom::InputError with file, line and names for an unknown key, a missing or doubled name, an
/// unknown reference, a negative, out-of-range or non-finite value.
Spindle read_spindle(const std::string& path);

/// The same from text; `file` is only for messages.
Spindle parse_spindle(const std::string& text, const std::string& file);

}  // namespace spindle_twin::fem_offline
