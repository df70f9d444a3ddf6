#pragma once

#include <numbers>
#include <optional>

#include "rom/laws/interference_fit.hpp"
#include "rom/laws/law.hpp"
#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

enum class ContactFormula : std::uint8_t {
  plastic,  ///< Cooper, Mikic, Yovanovich 1969 + gap: first loading of ground surfaces
  elastic,  ///< Mikic 1974 + gap: surfaces loaded before, polished
  paper,    ///< the seed paper's eq. 5, no gap
};

/// Two nominally flat surfaces.
struct ContactSurfaces {
  ContactFormula formula = ContactFormula::plastic;
  double conductivity_W_per_mK = 0.0;         ///< k_s = 2k₁k₂/(k₁+k₂)
  double roughness_m = 0.0;                   ///< σ = √(σ₁² + σ₂²), rms
  double slope = 0.0;                         ///< m = √(m₁² + m₂²), mean absolute asperity slope
  double hardness_Pa = 3e9;                   ///< H_c of the softer: ground steel 2 to 4 GPa
  double young_Pa = 0.0;                      ///< E' = 1/((1−ν₁²)/E₁ + (1−ν₂²)/E₂)
  double gap_conductivity_W_per_mK = 0.0262;  ///< air; 0.13 oil or grease
  double gas_jump_m = 2.77e-7;                ///< M: see gas_jump_m(); 0 for a liquid
  double paper_constant = 105.6;              ///< of eq. 5, whose origin is not known: a calibration constant
};

/// M = (Σ (2 − a_i)/a_i) · 2γ/((1 + γ) Pr) · Λ [m]: the temperature jump of a gas at two walls of accommodation a
/// (Yovanovich).
inline double gas_jump_m(double accommodation_1, double accommodation_2, double heat_ratio, double prandtl,
                         double free_path_m) {
  const double walls = (2.0 - accommodation_1) / accommodation_1 + (2.0 - accommodation_2) / accommodation_2;
  return walls * 2.0 * heat_ratio / ((1.0 + heat_ratio) * prandtl) * free_path_m;
}

/// Harmonic mean conductivity and the two root sums of squares, for filling ContactSurfaces.
inline double harmonic_mean(double a, double b) { return 2.0 * a * b / (a + b); }

/// P that the laws see: standard, not below 1e-6 H_c (exact above 2e-6 H_c), so that h stays positive and smooth at P =
/// 0.
template <class Scalar>
Scalar contact_pressure_Pa(LawMode mode, const ContactSurfaces& surfaces, const Scalar& pressure_Pa) {
  if (mode == LawMode::standard) return floor_at(pressure_Pa, 1e-6 * surfaces.hardness_Pa);
  return real_part(pressure_Pa) > 0.0 ? pressure_Pa : Scalar(0.0);
}

/// Solid spots [W/m²K]:  plastic 1.25 k_s (m/σ)(P/H_c)^0.95,  elastic 1.55 k_s (m/σ)(√2 P/(m E'))^0.94. Cycle-safe.
template <class Scalar>
Scalar spot_conductance_W_per_m2K(const ContactSurfaces& surfaces, const Scalar& pressure_Pa) {
  using std::pow;
  const double shape = surfaces.conductivity_W_per_mK * surfaces.slope / surfaces.roughness_m;
  if (surfaces.formula == ContactFormula::elastic) {
    return 1.55 * shape * pow(Scalar(std::sqrt(2.0) * pressure_Pa / (surfaces.slope * surfaces.young_Pa)), 0.94);
  }
  return 1.25 * shape * pow(Scalar(pressure_Pa / surfaces.hardness_Pa), 0.95);
}

/// Mean distance of the surfaces' mean planes [m]:  Y = 1.53 σ (P/H_c)^−0.097 (Yovanovich). Cycle-safe.
template <class Scalar>
Scalar plane_distance_m(const ContactSurfaces& surfaces, const Scalar& pressure_Pa) {
  using std::pow;
  return 1.53 * surfaces.roughness_m * pow(Scalar(pressure_Pa / surfaces.hardness_Pa), -0.097);
}

/// What fills the gaps [W/m²K]:  k_g/(Y + c + M), c the clearance of an open joint. Cycle-safe.
template <class Scalar>
Scalar gap_conductance_W_per_m2K(const ContactSurfaces& surfaces, const Scalar& pressure_Pa,
                                 const Scalar& clearance_m) {
  return surfaces.gap_conductivity_W_per_mK /
         (plane_distance_m(surfaces, pressure_Pa) + clearance_m + surfaces.gas_jump_m);
}

/// Resistance of eq. 5, r/(R k) = 105.6 (P/E)^0.68. In SI throughout [m²K/W] unless as_printed: the printed units
/// (r µm, k W/mK, P MPa, E GPa) put in as numbers, 9.1e3 times as much. Cycle-safe.
template <class Scalar>
Scalar paper_resistance(LawMode mode, const ContactSurfaces& surfaces, const Scalar& pressure_Pa) {
  using std::pow;
  const double units = mode == LawMode::as_printed ? 1e6 * std::pow(1e3, -0.68) : 1.0;
  return units * surfaces.roughness_m / surfaces.conductivity_W_per_mK /
         (surfaces.paper_constant * pow(Scalar(pressure_Pa / surfaces.young_Pa), 0.68));
}

/// Conductance of a joint under mean pressure P, with clearance c >= 0 where it stands open [W/m²K]:
///   plastic, elastic  h = h_spots + h_gap       paper  h = 1/R of eq. 5
/// dh/dP = 0.95 h_spots/P + 0.097 h_gap Y/(P (Y + c + M)). Range: 1e-6 < P/H_c < 2.3e-2. As printed means eq. 5 with
/// its literal units whatever the formula. Uncertain by a factor of 2: a prior, not a truth. Cycle-safe.
template <class Scalar>
LawValue<Scalar> contact_conductance_W_per_m2K(LawMode mode, const ContactSurfaces& surfaces, const Scalar& pressure_Pa,
                                               const Scalar& clearance_m) {
  const Scalar P = contact_pressure_Pa(mode, surfaces, pressure_Pa);
  auto flags = range_flags(pressure_Pa, 1e-6 * surfaces.hardness_Pa, 2.3e-2 * surfaces.hardness_Pa);
  if (real_part(clearance_m) > 0.0) flags |= joint_open;
  if (real_part(P) <= 0.0) return {Scalar(0.0), static_cast<std::uint16_t>(flags | joint_open)};
  if (surfaces.formula == ContactFormula::paper || mode == LawMode::as_printed) {
    return {1.0 / paper_resistance(mode, surfaces, P), flags};
  }
  return {spot_conductance_W_per_m2K(surfaces, P) + gap_conductance_W_per_m2K(surfaces, P, clearance_m), flags};
}

inline constexpr std::array<std::string_view, 3> contact_formulas = {"plastic", "elastic", "paper"};

/// [W/m²K]: first = inner body, second = outer body of the fit; without a fit the pressure input decides.
struct ContactLaw {
  static constexpr LawTraits traits{"contact", LawRole::conductance, {"inner_body", "outer_body"}};
  ContactSurfaces surfaces;
  std::optional<InterferenceFit> fit;
  double assembly_K = 293.15;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"formula", {0.0, 2.0, false, false}, false, si, contact_formulas}, law.surfaces.formula);
    visit({"conductivity_W_per_mK", law_ranges::above_0, true, si, {}}, law.surfaces.conductivity_W_per_mK);
    visit({"roughness_m", law_ranges::length_m, true, um, {}}, law.surfaces.roughness_m);
    visit({"slope", {0.0, 10.0, true, false}, true, si, {}}, law.surfaces.slope);
    visit({"hardness_Pa", law_ranges::above_0, false, si, {}}, law.surfaces.hardness_Pa);
    visit({"young_Pa", law_ranges::above_0, true, si, {}}, law.surfaces.young_Pa);
    visit({"gap_conductivity_W_per_mK", law_ranges::from_0, false, si, {}}, law.surfaces.gap_conductivity_W_per_mK);
    visit({"gas_jump_m", {0.0, 1.0, false, false}, false, um, {}}, law.surfaces.gas_jump_m);
    visit({"paper_constant", law_ranges::above_0, false, si, {}}, law.surfaces.paper_constant);
    visit({"assembly_K", law_ranges::kelvin, false, degC, {}}, law.assembly_K);
    visit.optional("fit", law.fit, [&](auto& given) { InterferenceFit::each(given, visit); });
  }
  bool reads_pressure() const { return !fit; }
  std::string_view fault() const {
    if (!fit || (fit->bore_radius_m < fit->joint_radius_m && fit->joint_radius_m < fit->outer_radius_m)) return {};
    return "fit_joint_radius_m: must lie between bore and outer radius";
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    if (!fit) return contact_conductance_W_per_m2K(in.mode, surfaces, in.pressure_Pa, Number(0.0));
    const auto pressed = fit_state(in.mode, *fit, Number(in.first_K - assembly_K), Number(in.second_K - assembly_K),
                                   Number(in.speed_rpm * (std::numbers::pi / 30.0)));
    auto conductance = contact_conductance_W_per_m2K(in.mode, surfaces, pressed.pressure_Pa, pressed.gap_m);
    conductance.flags |= pressed.flags;
    return conductance;
  }
  static ContactLaw example() {
    ContactLaw law;
    law.surfaces.conductivity_W_per_mK = 45.9;
    law.surfaces.roughness_m = 1.13e-6;
    law.surfaces.slope = 0.141;
    law.surfaces.young_Pa = 116e9;
    return law;
  }
};

}  // namespace spindle_twin::rom
