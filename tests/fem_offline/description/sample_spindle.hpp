#pragma once

#include <stdexcept>
#include <string>

#include "fem_offline/mesh/section.hpp"

namespace spindle_twin::fem_offline {

/// A material for descriptions in tests.
inline const std::string steel_text = R"([[material]]
name = "steel"
conductivity_r_W_per_mK = 48
density_kg_per_m3 = 7830
heat_capacity_J_per_kgK = 450
youngs_modulus_Pa = 209e9
poisson_ratio = 0.3
expansion_per_K = 1.17e-5
)";

/// A shaft in a sleeve with everything a description can hold, as text to be spoilt one line at a time.
inline const std::string sample_text = R"(name = "sample"
[operating]
speed_rpm = 3000
load = 0.5
reference_temperature_degC = 20
temperatures_degC = { room = 22, water = 18 }
[mesh]
element_size_mm = 3
degree = 1
)" + steel_text + R"([[material]]
name = "stack"
conductivity_r_W_per_mK = 25
conductivity_z_W_per_mK = 4
density_kg_per_m3 = 7650
heat_capacity_J_per_kgK = 460
youngs_modulus_Pa = 150e9
poisson_ratio = 0.25
expansion_per_K = 1.2e-5
[[part]]
name = "shaft"
material = "steel"
rectangles = [[0, 20, 0, 100]]
[[part]]
name = "sleeve"
material = "stack"
rectangles = [[20, 40, 0, 100]]
cut_rectangles = [[38, 40, 40, 60]]
[[contact]]
between = ["shaft", "sleeve"]
conductance_W_per_m2K = 5000
interference_fit = { inner_radius_mm = 0, fit_radius_mm = 20, outer_radius_mm = 40, interference_um = 6 }
[[surrounding]]
name = "room"
kind = "ambient"
[[surrounding]]
name = "water"
kind = "coolant"
[[surrounding]]
name = "pocket"
kind = "air"
capacity_J_per_K = 0.2
[[film]]
name = "ends"
coefficient_W_per_m2K = 8
surrounding = "room"
regions = [[0, 40, -1, 0], [0, 40, 100, 101]]
speed_law = { constant = 0.25, speed_terms = [[0.75, 0.5]] }
[[film]]
name = "groove"
coefficient_W_per_m2K = 300
surrounding = "water"
regions = [[38, 40, 40, 60]]
[[film]]
name = "outside"
coefficient_W_per_m2K = 12
surrounding = "pocket"
regions = [[40, 50, 0, 40]]
only_parts = ["sleeve"]
[[adiabatic]]
name = "lagging"
regions = [[40, 50, 60, 100]]
[[heat]]
name = "core"
density_W_per_m3 = 1e5
shares = [{ part = "shaft" }, { part = "sleeve", weight = 0.5 }]
speed_law = { speed_terms = [[0.5, 1.0]], load_squared = 0.5, zero_at_standstill = true }
[[heat]]
name = "friction"
heat_W = 10
shares = [
  { part = "shaft", on_contact_with = "sleeve", weight = 0.75 },
  { part = "sleeve", on_face = [40, 40, 60, 80], weight = 0.25 },
]
[[support]]
part = "sleeve"
face = [20, 40, 100, 100]
[[key_point]]
name = "bore"
part = "sleeve"
at = [20, 50]
[[deformation]]
name = "nose"
part = "shaft"
face = [0, 20, 0, 0]
positive_along = "-z"
)";

/// The sample with one piece of text replaced; throws if that piece is not there exactly once.
inline std::string sample_with(const std::string& from, const std::string& to) {
  const auto at = sample_text.find(from);
  if (at == std::string::npos || sample_text.find(from, at + 1) != std::string::npos) {
    throw std::logic_error("the sample does not hold this text once: " + from);
  }
  std::string text = sample_text;
  return text.replace(at, from.size(), to);
}

/// The message that reading the text and building its section ends in.
inline std::string message_of(const std::string& text) {
  try {
    build_section(parse_spindle(text, "s.toml"));
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "no InputError";
}

}  // namespace spindle_twin::fem_offline
