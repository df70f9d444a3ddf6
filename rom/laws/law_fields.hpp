#pragma once

#include <array>
#include <concepts>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "rom/laws/evaluate.hpp"
#include "rom/range.hpp"

/// One list of every law's numbers, from which descriptions are read, files written and checked, and networks shown and
/// compared. Not for the cycle.
namespace spindle_twin::rom {

/// The unit that a person writes, where it is not the SI unit of the number.
enum class WrittenUnit { si, mm, um, mm2, degree, degC };

/// One number of a law. `name` ends in its SI unit; what a person writes ends in that of `written`.
struct LawField {
  std::string_view name;
  Range range;         ///< SI
  bool needed = true;  ///< otherwise a description may leave it at its default
  WrittenUnit written = WrittenUnit::si;
  std::span<const std::string_view> words;  ///< of a choice, whose number is the index; else empty
};

inline constexpr std::array<std::string_view, 3> contact_formulas = {"plastic", "elastic", "paper"};
inline constexpr std::array<std::string_view, 2> channel_formulas = {"gnielinski", "paper_trio"};
inline constexpr std::array<std::string_view, 3> rotation_formulas = {"standard", "dropkin_carmi", "jungnickel"};
inline constexpr std::array<std::string_view, 2> off_on = {"off", "on"};
inline constexpr std::array<std::string_view, 3> law_modes = {"standard", "as_published", "as_printed"};

/// Words of LawParameters' alternatives, in their order.
inline constexpr std::array<std::string_view, std::variant_size_v<LawParameters>> law_kinds = {
    "bearing_friction",  "windage",       "copper_loss",    "motor_efficiency", "iron_loss",   "contact",     "channel",
    "rotating_cylinder", "rotating_disc", "still_cylinder", "air_gap",          "end_winding", "bearing_path"};

/// What the law of a kind reads as first and second temperature, as a person names it; empty: nothing.
struct LawTemperatureNames {
  std::string_view first;
  std::string_view second;
};
inline constexpr std::array<LawTemperatureNames, std::variant_size_v<LawParameters>> law_temperatures = {
    {{"inner_ring", "outer_ring"},
     {"rotor", "stator"},
     {"winding", ""},
     {"", ""},
     {"", ""},
     {"inner_body", "outer_body"},
     {"wall", "liquid"},
     {"surface", "air"},
     {"surface", "air"},
     {"surface", "air"},
     {"rotor", "stator"},
     {"", ""},
     {"", ""}}};

namespace law_fields {

template <class T, class Law>
concept Is = std::same_as<std::remove_const_t<T>, Law>;

inline constexpr Range any{-1e15, 1e15, false, false};
inline constexpr Range length_m{0.0, 1e3, true, false};
inline constexpr Range share{0.0, 1.0, true, true};
inline constexpr Range above_0{0.0, 1e15, true, false};
inline constexpr Range from_0{0.0, 1e15, false, false};
inline constexpr Range kelvin{0.0, 1e4, true, false};
inline constexpr Range angle_rad{0.0, 1.5707, true, true};
inline constexpr Range expansion{0.0, 1e-2, false, false};

/// Calls visit(LawField, number) for every number of `law` (const or not): a double, a bool or an enumeration; and
/// visit.optional(name, std::optional<...>, body) around the numbers of what may be missing.
template <Is<BearingHeatLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"pitch_diameter_m", length_m, true, mm, {}}, law.friction.pitch_diameter_m);
  visit({"viscous_factor", from_0, true, si, {}}, law.friction.viscous_factor);
  visit({"static_rating_N", above_0, true, si, {}}, law.friction.static_rating_N);
  visit({"contact_angle_rad", angle_rad, true, degree, {}}, law.friction.contact_angle_rad);
  visit({"load_factor", from_0, false, si, {}}, law.friction.load_factor);
  visit({"load_exponent", {0.0, 5.0, false, false}, false, si, {}}, law.friction.load_exponent);
  visit({"inlet_shear", {0.0, 1.0, false, false}, false, si, off_on}, law.friction.inlet_shear);
  visit({"balls", {1.0, 1e4, false, false}, true, si, {}}, law.preload.balls);
  visit({"ball_diameter_m", length_m, true, mm, {}}, law.preload.ball_diameter_m);
  visit({"preload_angle_rad", angle_rad, false, degree, {}}, law.preload.contact_angle_rad);
  visit({"preload_N", above_0, true, si, {}}, law.preload.initial_N);
  visit({"spring_N_per_m", from_0, false, si, {}}, law.preload.spring_N_per_m);
  visit({"inner_contact_radius_m", length_m, false, mm, {}}, law.preload.inner_radius_m);
  visit({"outer_contact_radius_m", length_m, false, mm, {}}, law.preload.outer_radius_m);
  visit({"ring_expansion_per_K", expansion, false, si, {}}, law.preload.ring_expansion_per_K);
  visit({"ball_expansion_per_K", expansion, false, si, {}}, law.preload.ball_expansion_per_K);
  visit({"walther_a", {0.0, 100.0, true, false}, false, si, {}}, law.oil.walther_a);
  visit({"walther_b", {0.0, 100.0, true, false}, false, si, {}}, law.oil.walther_b);
  visit({"radial_N", from_0, false, si, {}}, law.radial_N);
  visit({"assembly_K", kelvin, false, degC, {}}, law.assembly_K);
}

template <Is<WindageLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"rotor_radius_m", length_m, true, mm, {}}, law.shape.rotor_radius_m);
  visit({"gap_m", length_m, true, mm, {}}, law.shape.gap_m);
  visit({"length_m", length_m, true, mm, {}}, law.shape.length_m);
  visit({"end_bore_radius_m", {0.0, 1e3, false, false}, false, mm, {}}, law.shape.end_bore_radius_m);
  visit({"roughness", above_0, false, si, {}}, law.shape.roughness);
  visit({"printed_coefficient", from_0, false, si, {}}, law.shape.printed_coefficient);
}

template <Is<CopperLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"resistance_20_ohm", above_0, true, si, {}}, law.copper.resistance_20_ohm);
  visit({"rated_current_A", from_0, true, si, {}}, law.rated_current_A);
  visit({"phases", {1.0, 100.0, false, false}, false, si, {}}, law.copper.phases);
  visit({"temperature_per_K", {0.0, 0.1, false, false}, false, si, {}}, law.copper.temperature_per_K);
  visit({"ac_ratio", {1.0, 1e3, false, false}, false, si, {}}, law.copper.ac_ratio);
  visit({"printed_resistivity", from_0, false, si, {}}, law.copper.printed_resistivity);
}

template <Is<MotorEfficiencyLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  visit({"efficiency", {0.0, 1.0, true, false}, true, WrittenUnit::si, {}}, law.efficiency);
  visit({"rated_power_W", from_0, true, WrittenUnit::si, {}}, law.rated_power_W);
}

template <Is<IronLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"core_mass_kg", above_0, true, si, {}}, law.iron.mass_kg);
  visit({"pole_pairs", {1.0, 1e3, false, false}, true, si, {}}, law.pole_pairs);
  visit({"base_flux_T", {0.0, 10.0, false, false}, true, si, {}}, law.base_flux_T);
  visit({"base_speed_rpm", above_0, true, si, {}}, law.base_speed_rpm);
  visit({"slip_Hz", {0.0, 1e4, false, false}, false, si, {}}, law.slip_Hz);
  visit({"hysteresis", from_0, false, si, {}}, law.iron.hysteresis);
  visit({"excess", from_0, false, si, {}}, law.iron.excess);
  visit({"lamination_m", length_m, false, mm, {}}, law.iron.lamination_m);
  visit({"resistivity_ohm_m", above_0, false, si, {}}, law.iron.resistivity_ohm_m);
  visit({"density_kg_per_m3", above_0, false, si, {}}, law.iron.density_kg_per_m3);
  visit({"relative_permeability", above_0, false, si, {}}, law.iron.relative_permeability);
  visit({"build_factor", above_0, false, si, {}}, law.iron.build_factor);
}

template <Is<InterferenceFit> Fit, class Visit>
void each(Fit& fit, Visit&& visit) {
  using enum WrittenUnit;
  visit({"fit_bore_radius_m", {0.0, 1e3, false, false}, true, mm, {}}, fit.bore_radius_m);
  visit({"fit_joint_radius_m", length_m, true, mm, {}}, fit.joint_radius_m);
  visit({"fit_outer_radius_m", length_m, true, mm, {}}, fit.outer_radius_m);
  visit({"fit_interference_m", {-0.1, 0.1, false, false}, true, um, {}}, fit.interference_m);
  visit({"fit_inner_young_Pa", above_0, true, si, {}}, fit.inner_young_Pa);
  visit({"fit_inner_poisson", {0.0, 0.5, false, true}, true, si, {}}, fit.inner_poisson);
  visit({"fit_inner_expansion_per_K", expansion, true, si, {}}, fit.inner_expansion_per_K);
  visit({"fit_outer_young_Pa", above_0, true, si, {}}, fit.outer_young_Pa);
  visit({"fit_outer_poisson", {0.0, 0.5, false, true}, true, si, {}}, fit.outer_poisson);
  visit({"fit_outer_expansion_per_K", expansion, true, si, {}}, fit.outer_expansion_per_K);
  visit({"fit_centrifugal_m_s2", from_0, false, si, {}}, fit.centrifugal_m_s2);
  visit({"fit_corner_m", {1e-12, 1e-3, false, false}, false, um, {}}, fit.corner_m);
}

template <Is<ContactLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"formula", {0.0, 2.0, false, false}, false, si, contact_formulas}, law.surfaces.formula);
  visit({"conductivity_W_per_mK", above_0, true, si, {}}, law.surfaces.conductivity_W_per_mK);
  visit({"roughness_m", length_m, true, um, {}}, law.surfaces.roughness_m);
  visit({"slope", {0.0, 10.0, true, false}, true, si, {}}, law.surfaces.slope);
  visit({"hardness_Pa", above_0, false, si, {}}, law.surfaces.hardness_Pa);
  visit({"young_Pa", above_0, true, si, {}}, law.surfaces.young_Pa);
  visit({"gap_conductivity_W_per_mK", from_0, false, si, {}}, law.surfaces.gap_conductivity_W_per_mK);
  visit({"gas_jump_m", {0.0, 1.0, false, false}, false, um, {}}, law.surfaces.gas_jump_m);
  visit({"paper_constant", above_0, false, si, {}}, law.surfaces.paper_constant);
  visit({"assembly_K", kelvin, false, degC, {}}, law.assembly_K);
  visit.optional("fit", law.fit, [&](auto& fit) { each(fit, visit); });
}

template <Is<ChannelLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  using enum WrittenUnit;
  visit({"formula", {0.0, 1.0, false, false}, false, si, channel_formulas}, law.shape.formula);
  visit({"hydraulic_diameter_m", length_m, true, mm, {}}, law.shape.hydraulic_diameter_m);
  visit({"perimeter_m", length_m, true, mm, {}}, law.shape.perimeter_m);
  visit({"length_m", length_m, true, mm, {}}, law.shape.length_m);
  visit({"coil_diameter_m", {0.0, 1e3, false, false}, false, mm, {}}, law.shape.coil_diameter_m);
  visit({"laminar_limit", {0.1, 100.0, false, false}, false, si, {}}, law.shape.laminar_limit);
  visit({"liquid_viscosity_Pa_s", above_0, false, si, {}}, law.liquid.viscosity_Pa_s);
  visit({"liquid_vogel_K", {0.0, 1e4, false, false}, false, si, {}}, law.liquid.vogel_K);
  visit({"liquid_vogel_zero_K", {0.0, 1e4, false, false}, false, si, {}}, law.liquid.vogel_zero_K);
  visit({"liquid_conductivity_W_per_mK", any, false, si, {}}, law.liquid.conductivity_W_per_mK);
  visit({"liquid_conductivity_slope_W_per_mK2", any, false, si, {}}, law.liquid.conductivity_slope_W_per_mK2);
  visit({"liquid_conductivity_curve_W_per_mK3", any, false, si, {}}, law.liquid.conductivity_curve_W_per_mK3);
  visit({"liquid_density_kg_per_m3", above_0, false, si, {}}, law.liquid.density_kg_per_m3);
  visit({"liquid_heat_capacity_J_per_kgK", above_0, false, si, {}}, law.liquid.heat_capacity_J_per_kgK);
  visit({"liquid_coldest_K", kelvin, false, degC, {}}, law.liquid.coldest_K);
  visit({"liquid_hottest_K", kelvin, false, degC, {}}, law.liquid.hottest_K);
}

template <class Law, class Visit>
requires(Is<Law, CylinderLaw> || Is<Law, DiscLaw>) void each(Law& law, Visit&& visit) {
  visit({"radius_m", length_m, true, WrittenUnit::mm, {}}, law.surface.radius_m);
  visit({"formula", {0.0, 2.0, false, false}, false, WrittenUnit::si, rotation_formulas}, law.surface.formula);
}

template <Is<StillCylinderLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  visit({"radius_m", length_m, true, WrittenUnit::mm, {}}, law.radius_m);
}

template <Is<AirGapLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  visit({"rotor_radius_m", length_m, true, WrittenUnit::mm, {}}, law.gap.rotor_radius_m);
  visit({"gap_m", length_m, true, WrittenUnit::mm, {}}, law.gap.gap_m);
  visit({"rotor_expansion_per_K", expansion, false, WrittenUnit::si, {}}, law.gap.rotor_expansion_per_K);
}

template <Is<EndWindingLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  visit({"radius_m", length_m, true, WrittenUnit::mm, {}}, law.radius_m);
  visit({"still_W_per_m2K", above_0, false, WrittenUnit::si, {}}, law.winding.still_W_per_m2K);
  visit({"speed_factor", from_0, false, WrittenUnit::si, {}}, law.winding.speed_factor);
  visit({"exponent", {0.0, 2.0, true, true}, false, WrittenUnit::si, {}}, law.winding.exponent);
}

template <Is<BearingPathLaw> Law, class Visit>
void each(Law& law, Visit&& visit) {
  visit({"balls", {1.0, 1e4, false, false}, true, WrittenUnit::si, {}}, law.bearing.balls);
  visit({"ball_diameter_m", length_m, true, WrittenUnit::mm, {}}, law.bearing.ball_diameter_m);
  visit({"inner_raceway_radius_m", length_m, true, WrittenUnit::mm, {}}, law.bearing.inner_raceway_radius_m);
  visit({"area_m2", above_0, true, WrittenUnit::mm2, {}}, law.area_m2);
}

}  // namespace law_fields

/// Name and value of one number of a law, SI.
struct NamedNumber {
  std::string name;
  double value = 0.0;
};

/// The law of a kind with its default numbers; nothing for an unknown kind.
std::optional<LawParameters> default_law(std::string_view kind);

/// All numbers of a law in the order of law_fields; a fit that is missing has none.
std::vector<NamedNumber> law_numbers(const LawParameters& parameters);

/// The law of `kind` (one of law_kinds) from its numbers. Throws std::invalid_argument, saying what is wrong, for an
/// unknown kind or name, a number that is missing, given twice or outside its range.
LawParameters law_from_numbers(const std::string& kind, const std::vector<NamedNumber>& numbers);

/// Empty, or what is wrong with the law's numbers: a name and what is allowed.
std::string law_fault(const LawParameters& parameters);

/// Whether it is the film of a coolant circuit's segments.
bool is_channel(const PhysicalLaw& law);

}  // namespace spindle_twin::rom
