#pragma once

#include <numbers>

#include "rom/laws/bearing_preload.hpp"
#include "rom/laws/fluid.hpp"
#include "rom/laws/law.hpp"
#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

struct BearingFriction {
  double pitch_diameter_m = 0.0;  ///< D
  double viscous_factor = 1.7;   ///< f₀ of angular contact, one row: grease 2, oil-air 1.7, oil bath 3.3, oil jet 6.6
  double static_rating_N = 0.0;  ///< C_s
  double load_factor = 0.001;    ///< z: 0.001 at 30° contact angle, 0.0013 at 40°
  double load_exponent = 0.33;   ///< y
  double contact_angle_rad = 0.0;
  bool inlet_shear = false;  ///< multiply the viscous part by φ_ish, for a high n D
};

/// φ_ish = 1/(1 + 1.84e-9 (n D)^1.28 ν^0.64), n in rpm, D in mm, ν in mm²/s (SKF catalogue): the film's own heat at its
/// inlet thins it. Cycle-safe.
template <class Scalar>
Scalar inlet_shear_factor(double pitch_diameter_m, const Scalar& viscosity_m2_per_s, const Scalar& speed_rpm) {
  using std::pow;
  const Scalar rate = pow(Scalar(magnitude(speed_rpm) * (pitch_diameter_m * 1e3)), 1.28);
  return 1.0 / (1.0 + 1.84e-9 * rate * pow(Scalar(viscosity_m2_per_s * 1e6), 0.64));
}

/// Viscous torque [N m] of Palmgren 1959 with x = ν|n| in mm²/s · rpm, D in mm:
///   as published  160e-7 f₀ D³ N mm (x < 2000), 1e-7 f₀ x^(2/3) D³       jumps by −0.8 % at 2000
///   standard      160e-7 f₀ D³ exp(ramp(ln(x^(2/3)/160), 0.1))           the same outside 1742 < x < 2351
///   as printed    160 f₀ D³ below 2000: 1e7 times too much; x keeps the sign of the speed
/// Cycle-safe.
template <class Scalar>
Scalar viscous_torque_Nm(LawMode mode, const BearingFriction& bearing, const Scalar& viscosity_m2_per_s,
                         const Scalar& speed_rpm) {
  using std::pow;
  const double diameter_mm = bearing.pitch_diameter_m * 1e3;
  const double f0D3 = 1e-3 * bearing.viscous_factor * diameter_mm * diameter_mm * diameter_mm;
  const Scalar signed_x = viscosity_m2_per_s * 1e6 * speed_rpm;
  if (mode == LawMode::as_printed) {
    return real_part(signed_x) < 2000.0 ? Scalar(160.0 * f0D3) : 1e-7 * f0D3 * pow(signed_x, 2.0 / 3.0);
  }
  const Scalar power = pow(magnitude(signed_x), 2.0 / 3.0);
  Scalar torque = real_part(magnitude(signed_x)) < 2000.0 ? Scalar(160e-7 * f0D3) : 1e-7 * f0D3 * power;
  if (mode == LawMode::standard) torque = 1e-7 * f0D3 * logmax(Scalar(160.0), power, 0.1);
  if (bearing.inlet_shear) torque *= inlet_shear_factor(bearing.pitch_diameter_m, viscosity_m2_per_s, speed_rpm);
  return torque;
}

/// P₁ = max(0.9 F_a cot α − 0.1 F_r, F_r) [N] (Harris), the corner of the standard one rounded within ±1 % of C_s.
/// Cycle-safe.
template <class Scalar>
Scalar friction_load_N(LawMode mode, const BearingFriction& bearing, const Scalar& axial_N, double radial_N) {
  const Scalar thrust = 0.9 / std::tan(bearing.contact_angle_rad) * axial_N - 0.1 * radial_N;
  if (mode == LawMode::standard) return smooth_max(thrust, Scalar(radial_N), 0.01 * bearing.static_rating_N);
  return real_part(thrust) > radial_N ? thrust : Scalar(radial_N);
}

/// Load torque M₁ = f₁ P₁ D [N m], f₁ = z (P₁/C_s)^y. Cycle-safe.
template <class Scalar>
Scalar load_torque_Nm(const BearingFriction& bearing, const Scalar& load_N) {
  using std::pow;
  if (real_part(load_N) <= 0.0) return Scalar(0.0);
  const Scalar f1 = bearing.load_factor * pow(Scalar(load_N / bearing.static_rating_N), bearing.load_exponent);
  return f1 * load_N * bearing.pitch_diameter_m;
}

/// Friction heat of one row [W]:  Q = (2π/60)|n| (M₀ + M₁), |n| of the standard one rounded below 1 rpm so that
/// reversal has no corner. As printed the factor is 1.047e-4 (0.02 % low) and n keeps its sign: heat is negative in
/// reverse. thin_film below 2 mm²/s; above_range above n D = 1e6 rpm mm without the inlet shear factor. Cycle-safe.
template <class Scalar>
LawValue<Scalar> bearing_heat_W(LawMode mode, const BearingFriction& bearing, const Scalar& viscosity_m2_per_s,
                                const Scalar& axial_N, double radial_N, const Scalar& speed_rpm) {
  const Scalar torque_Nm = viscous_torque_Nm(mode, bearing, viscosity_m2_per_s, speed_rpm) +
                           load_torque_Nm(bearing, friction_load_N(mode, bearing, axial_N, radial_N));
  LawValue<Scalar> result;
  if (real_part(viscosity_m2_per_s) < 2e-6) result.flags |= thin_film;
  if (!bearing.inlet_shear) {
    result.flags |= range_flags(magnitude(speed_rpm) * (bearing.pitch_diameter_m * 1e3), 0.0, 1e6);
  }
  switch (mode) {
    case LawMode::as_printed:
      result.value = 0.1047 * speed_rpm * torque_Nm;
      break;
    case LawMode::as_published:
      result.value = std::numbers::pi / 30.0 * magnitude(speed_rpm) * torque_Nm;
      break;
    case LawMode::standard:
      result.value = std::numbers::pi / 30.0 * smooth_power(speed_rpm, 1.0, 1.0) * torque_Nm;
  }
  return result;
}

/// Friction of one row [W]: first = inner ring, second = outer ring, displacement = axial closing of the rings.
/// Lubricant and balls have the mean temperature of both rings.
struct BearingHeatLaw {
  static constexpr LawTraits traits{
      "bearing_friction", LawRole::heat, {"inner_ring", "outer_ring"}, MeasuredDrive::none, true};
  BearingFriction friction;
  BearingPreload preload;
  Lubricant oil;
  double radial_N = 0.0;
  double assembly_K = 293.15;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"pitch_diameter_m", law_ranges::length_m, true, mm, {}}, law.friction.pitch_diameter_m);
    visit({"viscous_factor", law_ranges::from_0, true, si, {}}, law.friction.viscous_factor);
    visit({"static_rating_N", law_ranges::above_0, true, si, {}}, law.friction.static_rating_N);
    visit({"contact_angle_rad", law_ranges::angle_rad, true, degree, {}}, law.friction.contact_angle_rad);
    visit({"load_factor", law_ranges::from_0, false, si, {}}, law.friction.load_factor);
    visit({"load_exponent", {0.0, 5.0, false, false}, false, si, {}}, law.friction.load_exponent);
    visit({"inlet_shear", {0.0, 1.0, false, false}, false, si, off_on}, law.friction.inlet_shear);
    visit({"balls", {1.0, 1e4, false, false}, true, si, {}}, law.preload.balls);
    visit({"ball_diameter_m", law_ranges::length_m, true, mm, {}}, law.preload.ball_diameter_m);
    visit({"preload_angle_rad", law_ranges::angle_rad, false, degree, {}}, law.preload.contact_angle_rad);
    visit({"preload_N", law_ranges::above_0, true, si, {}}, law.preload.initial_N);
    visit({"spring_N_per_m", law_ranges::from_0, false, si, {}}, law.preload.spring_N_per_m);
    visit({"inner_contact_radius_m", law_ranges::length_m, false, mm, {}}, law.preload.inner_radius_m);
    visit({"outer_contact_radius_m", law_ranges::length_m, false, mm, {}}, law.preload.outer_radius_m);
    visit({"ring_expansion_per_K", law_ranges::expansion, false, si, {}}, law.preload.ring_expansion_per_K);
    visit({"ball_expansion_per_K", law_ranges::expansion, false, si, {}}, law.preload.ball_expansion_per_K);
    visit({"walther_a", {0.0, 100.0, true, false}, false, viscosities, {}}, law.oil.walther_a);
    visit({"walther_b", {0.0, 100.0, true, false}, false, viscosities, {}}, law.oil.walther_b);
    visit({"radial_N", law_ranges::from_0, false, si, {}}, law.radial_N);
    visit({"assembly_K", law_ranges::kelvin, false, degC, {}}, law.assembly_K);
  }
  /// The preload acts at the contact angle, the balls touch the rings where that angle and their diameter say.
  template <class Given>
  void complete(const Given& given) {
    const double angle_rad = friction.contact_angle_rad;
    const double offset_m = 0.5 * preload.ball_diameter_m * std::cos(angle_rad);
    if (!given("preload_angle_rad")) preload.contact_angle_rad = angle_rad;
    if (!given("inner_contact_radius_m")) preload.inner_radius_m = 0.5 * friction.pitch_diameter_m - offset_m;
    if (!given("outer_contact_radius_m")) preload.outer_radius_m = 0.5 * friction.pitch_diameter_m + offset_m;
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    const Number oil_K = in.mean_K();
    const auto nu = lubricant_viscosity_m2_per_s(in.mode, oil, oil_K);
    const auto axial_N = preload_N(preload, Number(in.first_K - assembly_K), Number(in.second_K - assembly_K),
                                   Number(oil_K - assembly_K), in.displacement_m);
    auto heat = bearing_heat_W(in.mode, friction, nu.value, axial_N.value, radial_N, in.speed_rpm);
    heat.flags |= nu.flags;
    heat.flags |= axial_N.flags;
    return heat;
  }
  static BearingHeatLaw example() {
    BearingHeatLaw law;
    law.friction.pitch_diameter_m = 0.065;
    law.friction.static_rating_N = 20000.0;
    law.friction.contact_angle_rad = 0.436;
    law.preload = {18.0, 9.525e-3, 0.436, 250.0, 0.0, 0.0275, 0.0375};
    law.oil = lubricant_through(313.15, 32e-6, 373.15, 5.4e-6);
    return law;
  }
};

}  // namespace spindle_twin::rom
