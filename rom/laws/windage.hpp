#pragma once

#include <numbers>

#include "rom/laws/fluid.hpp"
#include "rom/laws/law.hpp"

namespace spindle_twin::rom {

/// A rotor in its air gap.
struct WindageShape {
  double rotor_radius_m = 0.0;
  double gap_m = 0.0;
  double length_m = 0.0;
  double end_bore_radius_m = 0.0;  ///< inner radius of the free end faces; rotor_radius_m: no end face
  double roughness = 1.0;          ///< factor for slots, 1 to 4
  double printed_coefficient = 0.01;
};

/// C_f Re_δ of a smooth gap, C_f = P/(π ρ ω³ r⁴ L), Re_δ = ω r δ/ν >= 0, g = (δ/r)^0.3:
///   Bilgen, Boulos 1973: 5 g/Re (< 64), g/Re^0.6 (< 500), 0.515 g/Re^0.5 (< 1e4), 0.0325 g/Re^0.2     as published
///   Couette: 4k²/(k² − 1) · (δ/r)/Re, k = 1 + δ/r, exact in laminar flow and above the first two branches in a narrow
///   gap; standard: the largest of it and the two upper branches, corners rounded. Cycle-safe.
template <class Scalar>
Scalar gap_friction_times_reynolds(LawMode mode, double gap_over_radius, const Scalar& reynolds) {
  using std::pow;
  const double g = std::pow(gap_over_radius, 0.3);
  const Scalar upper = 0.515 * g * pow(reynolds, 0.5);
  const Scalar turbulent = 0.0325 * g * pow(reynolds, 0.8);
  if (mode == LawMode::standard) {
    const double k = 1.0 + gap_over_radius;
    const double couette = 4.0 * k * k / (k * k - 1.0) * gap_over_radius;
    return logmax(Scalar(couette), logmax(upper, turbulent, 0.2), 0.2);
  }
  if (real_part(reynolds) < 64.0) return Scalar(5.0 * g);
  if (real_part(reynolds) < 500.0) return g * pow(reynolds, 0.4);
  return real_part(reynolds) < 1e4 ? upper : turbulent;
}

/// Air friction of the rotor's cylinder [W]:  P = roughness · π C_f ρ ω³ r⁴ L.
/// As printed C_f is the constant printed_coefficient and ω³ keeps its sign: heat is negative in reverse.
/// Range: 1e-3 <= δ/r <= 0.5, Re_δ <= 1e6. Cycle-safe.
template <class Scalar>
LawValue<Scalar> gap_windage_W(LawMode mode, const WindageShape& shape, const Scalar& speed_rpm,
                               const Scalar& air_temperature_K) {
  const double r = shape.rotor_radius_m, delta = shape.gap_m;
  const FluidState<Scalar> gas = air(air_temperature_K);
  const Scalar omega = speed_rpm * (std::numbers::pi / 30.0);
  LawValue<Scalar> result{Scalar(0.0), gas.flags};
  const double r4L = std::numbers::pi * r * r * r * r * shape.length_m;
  if (mode == LawMode::as_printed) {
    result.value = shape.printed_coefficient * gas.density_kg_per_m3 * cube(omega) * r4L;
    return result;
  }
  const Scalar reynolds = magnitude(omega) * (r * delta) / gas.viscosity_m2_per_s;
  result.flags |= range_flags(reynolds, 0.0, 1e6);
  if (range_flags(delta / r, 1e-3, 0.5) != in_range) result.flags |= shape_out_of_range;
  if (real_part(omega) == 0.0) return result;
  // ω³ C_f = ω² (C_f Re) ν/(r δ): stays finite at standstill, where C_f does not.
  const Scalar friction = gap_friction_times_reynolds(mode, delta / r, reynolds);
  result.value =
      shape.roughness * gas.density_kg_per_m3 * square(omega) * r4L * friction * gas.viscosity_m2_per_s / (r * delta);
  return result;
}

/// Air friction of both end faces [W]:  P = ½ C_e ρ ω³ (r⁵ − r_i⁵), C_e = 3.87/Re^0.5 or 0.146/Re^0.2, Re = ω r²/ν
/// (von Kármán 1921). As published switched at Re = 3e5 (a jump of 66 %); standard mixed from 5e4 to 3e5 in ln Re.
/// Range: Re <= 1e7. The paper prints none: 0 as printed. Cycle-safe.
template <class Scalar>
LawValue<Scalar> end_windage_W(LawMode mode, const WindageShape& shape, const Scalar& speed_rpm,
                               const Scalar& air_temperature_K) {
  using std::log;
  using std::pow;
  const FluidState<Scalar> gas = air(air_temperature_K);
  LawValue<Scalar> result{Scalar(0.0), gas.flags};
  if (mode == LawMode::as_printed || real_part(speed_rpm) == 0.0) return result;
  const double r = shape.rotor_radius_m;
  const Scalar omega = speed_rpm * (std::numbers::pi / 30.0);
  const Scalar reynolds = magnitude(omega) * (r * r) / gas.viscosity_m2_per_s;
  const Scalar laminar = 3.87 * pow(reynolds, 0.5), turbulent = 0.146 * pow(reynolds, 0.8);
  Scalar weight = smoothstep(Scalar(log(reynolds)), std::log(5e4), std::log(3e5));
  if (mode == LawMode::as_published) weight = Scalar(real_part(reynolds) < 3e5 ? 0.0 : 1.0);
  const Scalar friction = laminar + weight * (turbulent - laminar);
  const double r5 = std::pow(r, 5) - std::pow(shape.end_bore_radius_m, 5);
  result.value = 0.5 * r5 * gas.density_kg_per_m3 * square(omega) * friction * gas.viscosity_m2_per_s / (r * r);
  result.flags |= range_flags(reynolds, 0.0, 1e7);
  return result;
}

/// Air friction of gap and ends [W]: first = rotor, second = stator; air at their mean.
struct WindageLaw {
  static constexpr LawTraits traits{"windage", LawRole::heat, {"rotor", "stator"}};
  WindageShape shape;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"rotor_radius_m", law_ranges::length_m, true, mm, {}}, law.shape.rotor_radius_m);
    visit({"gap_m", law_ranges::length_m, true, mm, {}}, law.shape.gap_m);
    visit({"length_m", law_ranges::length_m, true, mm, {}}, law.shape.length_m);
    visit({"end_bore_radius_m", {0.0, 1e3, false, false}, false, mm, {}}, law.shape.end_bore_radius_m);
    visit({"roughness", law_ranges::above_0, false, si, {}}, law.shape.roughness);
    visit({"printed_coefficient", law_ranges::from_0, false, si, {}}, law.shape.printed_coefficient);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    auto heat = gap_windage_W(in.mode, shape, in.speed_rpm, in.mean_K());
    const auto ends = end_windage_W(in.mode, shape, in.speed_rpm, in.mean_K());
    heat.value += ends.value;
    heat.flags |= ends.flags;
    return heat;
  }
  static WindageLaw example() { return {{0.04, 0.0005, 0.15}}; }
};

}  // namespace spindle_twin::rom
