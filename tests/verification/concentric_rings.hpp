#pragma once

#include <string>
#include <vector>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {

inline Polygon rectangle(double r0_m, double r1_m, double z0_m, double z1_m) {
  return {{r0_m, z0_m}, {r1_m, z0_m}, {r1_m, z1_m}, {r0_m, z1_m}};
}

inline Material steel(const std::string& name, double conductivity_W_per_mK, double heat_capacity_J_per_kgK = 450.0) {
  Material material;
  material.name = name;
  material.conductivity_r_W_per_mK = material.conductivity_z_W_per_mK = conductivity_W_per_mK;
  material.density_kg_per_m3 = 7830.0;
  material.heat_capacity_J_per_kgK = heat_capacity_J_per_kgK;
  material.youngs_modulus_Pa = 209e9;
  material.poisson_ratio = 0.269;
  material.expansion_per_K = 1.17e-5;
  return material;
}

/// Two concentric rings of 30 mm length in contact, adiabatic end faces, a film to 27 degC outside:
/// radii[0]..radii[1] is "inner", radii[1]..radii[2] is "outer".
inline Spindle concentric_rings(const std::vector<double>& radii_m, double contact_W_per_m2K, double film_W_per_m2K,
                                double ambient_K) {
  constexpr double length_m = 0.03;
  Spindle spindle;
  spindle.name = "concentric rings";
  spindle.materials = {steel("inner steel", 48.0), steel("outer steel", 44.0, 460.0)};
  Part inner, outer;
  inner.name = "inner";
  inner.shapes = {rectangle(radii_m[0], radii_m[1], 0.0, length_m)};
  outer.name = "outer";
  outer.material = 1;
  outer.shapes = {rectangle(radii_m[1], radii_m[2], 0.0, length_m)};
  spindle.parts = {inner, outer};
  Contact contact;
  contact.part_a = 0;
  contact.part_b = 1;
  contact.conductance_W_per_m2K = contact_W_per_m2K;
  spindle.contacts = {contact};
  Surrounding room;
  room.name = "room";
  spindle.surroundings = {room};
  Film film;
  film.name = "outside";
  film.coefficient_W_per_m2K = film_W_per_m2K;
  film.regions = {{radii_m[2], radii_m[2] + 0.01, 0.0, length_m}};
  spindle.films = {film};
  Adiabatic ends;
  ends.name = "ends";
  ends.regions = {{0.0, radii_m[2], -0.01, 0.0}, {0.0, radii_m[2], length_m, length_m + 0.01}};
  if (radii_m[0] > 0.0) ends.regions.push_back({0.0, radii_m[0], 0.0, length_m});
  spindle.adiabatics = {ends};
  spindle.operating.speed_rpm = 6000.0;
  spindle.operating.reference_temperature_K = ambient_K;
  spindle.operating.surrounding_K = {ambient_K};
  return spindle;
}

/// A solid shaft of 20 mm radius with 1e6 W/m3 in a sleeve of 40 mm; contact 5000 and film 200 W/m2K, 27 degC.
inline Spindle shaft_in_sleeve() {
  Spindle spindle = concentric_rings({0.0, 0.02, 0.04}, 5000.0, 200.0, 300.15);
  HeatSource heat;
  heat.name = "shaft";
  heat.density_W_per_m3 = 1e6;
  HeatShare share;
  share.part = 0;
  heat.shares = {share};
  spindle.heats = {heat};
  return spindle;
}

}  // namespace spindle_twin::fem_offline
