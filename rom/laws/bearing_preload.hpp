#pragma once

#include <numbers>

#include "rom/laws/law.hpp"
#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

/// A pair or set of angular contact bearings, one row of it.
struct BearingPreload {
  double balls = 0.0;
  double ball_diameter_m = 0.0;
  double contact_angle_rad = 0.0;
  double initial_N = 0.0;       ///< axial preload at assembly
  double spring_N_per_m = 0.0;  ///< > 0: spring preload, which the rings' rise does not change
  double inner_radius_m = 0.0;  ///< of the contact on the inner ring
  double outer_radius_m = 0.0;  ///< and on the outer ring
  double ring_expansion_per_K = 1.2e-5;
  double ball_expansion_per_K = 1.2e-5;
};

/// Stiffness of one ball's two contacts [N/m^1.5]: Palmgren's K = (1/4.36e-4)^1.5 √D_b in N and mm, steel on steel.
inline double ball_stiffness_N_per_m15(double ball_diameter_m) {
  return std::pow(1e3 / 4.36e-4, 1.5) * std::sqrt(ball_diameter_m * 1e3);
}

/// Approach of the rings along the contact line at assembly [m]: (F₀/(Z sin α K))^(2/3).
inline double initial_approach_m(const BearingPreload& bearing) {
  const double ball_N = bearing.initial_N / (bearing.balls * std::sin(bearing.contact_angle_rad));
  return std::pow(ball_N / ball_stiffness_N_per_m15(bearing.ball_diameter_m), 2.0 / 3.0);
}

/// Axial preload with the machine warm [N]:
///   rigid   F = Z sin α K ⟨d⟩^1.5,  d = d₀ + (u_i − u_o) cos α + z sin α + a_b D_b ΔT_b,  u = a r ΔT
///   spring  F = F₀ + k z, not below 0
/// Rises since assembly [K]; z [m] = how much nearer than at assembly the rings are axially (a deformation output;
/// negative for a shaft that outgrows its housing in O mounting). The paper says "proportional to temperature" and
/// gives no law, so there is one mode. joint_open where nothing is left. dF/dd = 1.5 F/d: continuous down to 0.
/// Cycle-safe.
template <class Scalar>
LawValue<Scalar> preload_N(const BearingPreload& bearing, const Scalar& inner_rise_K, const Scalar& outer_rise_K,
                           const Scalar& ball_rise_K, const Scalar& axial_m) {
  using std::pow;
  if (bearing.spring_N_per_m > 0.0) {
    const Scalar force = bearing.initial_N + bearing.spring_N_per_m * axial_m;
    const auto flags = real_part(force) <= 0.0 ? joint_open : in_range;
    return {ramp(force, 0.01 * bearing.initial_N), flags};
  }
  const double cosine = std::cos(bearing.contact_angle_rad), sine = std::sin(bearing.contact_angle_rad);
  const Scalar radial_m =
      bearing.ring_expansion_per_K * (bearing.inner_radius_m * inner_rise_K - bearing.outer_radius_m * outer_rise_K);
  const Scalar approach_m = initial_approach_m(bearing) + radial_m * cosine + axial_m * sine +
                            bearing.ball_expansion_per_K * bearing.ball_diameter_m * ball_rise_K;
  if (real_part(approach_m) <= 0.0) return {Scalar(0.0), joint_open};
  const double stiffness = ball_stiffness_N_per_m15(bearing.ball_diameter_m);
  return {bearing.balls * sine * stiffness * pow(approach_m, 1.5), in_range};
}

/// Share of the friction heat that the inner race takes (Jungnickel 2010): 0.5 + 1.08 (r_b/r_m)(1 − sin α)^0.37.
inline double inner_heat_share(double ball_radius_m, double pitch_radius_m, double contact_angle_rad) {
  return 0.5 + 1.08 * ball_radius_m / pitch_radius_m * std::pow(1.0 - std::sin(contact_angle_rad), 0.37);
}

struct BearingConductance {
  double balls = 0.0;
  double ball_diameter_m = 0.0;
  double inner_raceway_radius_m = 0.0;
};

/// Conductance from ring to ring through the balls [W/K] (FAG/Schäfer 1993):
///   G = 590 Z D_b² √(ln(ω (2 r_i + D_b)/2000) − ln D_b + 7)
/// ω in 1/s, not below 1; standard: the end at 1 rounded up to 2. Range: ω to 3000 1/s. Cycle-safe.
template <class Scalar>
LawValue<Scalar> bearing_conductance_W_per_K(LawMode mode, const BearingConductance& bearing, const Scalar& speed_rpm) {
  using std::log;
  using std::sqrt;
  const Scalar omega = magnitude(speed_rpm) * (std::numbers::pi / 30.0);
  Scalar held = floor_at(omega, 1.0);
  if (mode != LawMode::standard) held = real_part(omega) < 1.0 ? Scalar(1.0) : omega;
  const double Db = bearing.ball_diameter_m;
  const double orbit = (2.0 * bearing.inner_raceway_radius_m + Db) / (2000.0 * Db);
  const Scalar radicand = floor_at(Scalar(log(held) + std::log(orbit) + 7.0), 0.1);
  return {590.0 * bearing.balls * Db * Db * sqrt(radicand), range_flags(omega, 1.0, 3000.0)};
}

/// Central film thickness over effective radius (Hamrock, Dowson 1977): H = 2.69 U^0.67 G^0.53 W^−0.067 (1 − 0.61
/// exp(−0.73 k)), all numbers dimensionless, U > 0. A film below 1.5 times the roughness no longer separates the
/// surfaces, and f₀ of the friction law loses its meaning. Cycle-safe.
template <class Scalar>
Scalar film_thickness_ratio(const Scalar& speed, double material, double load, double ellipticity) {
  using std::pow;
  return 2.69 * pow(speed, 0.67) * std::pow(material, 0.53) * std::pow(load, -0.067) *
         (1.0 - 0.61 * std::exp(-0.73 * ellipticity));
}

/// [W/m²K] over area_m2: rings through the balls.
struct BearingPathLaw {
  static constexpr LawTraits traits{"bearing_path", LawRole::conductance};
  BearingConductance bearing;
  double area_m2 = 1.0;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"balls", {1.0, 1e4, false, false}, true, WrittenUnit::si, {}}, law.bearing.balls);
    visit({"ball_diameter_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.bearing.ball_diameter_m);
    visit({"inner_raceway_radius_m", law_ranges::length_m, true, WrittenUnit::mm, {}},
          law.bearing.inner_raceway_radius_m);
    visit({"area_m2", law_ranges::above_0, true, WrittenUnit::mm2, {}}, law.area_m2);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    auto path = bearing_conductance_W_per_K(in.mode, bearing, in.speed_rpm);
    path.value = path.value / area_m2;
    return path;
  }
  static BearingPathLaw example() { return {{18.0, 9.52e-3, 0.025}, 0.01}; }
};

}  // namespace spindle_twin::rom
