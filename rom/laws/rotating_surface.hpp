#pragma once

#include <numbers>

#include "rom/laws/fluid.hpp"
#include "rom/laws/law.hpp"

namespace spindle_twin::rom {

enum class RotationFormula : std::uint8_t {
  standard,       ///< cylinder: Becker 1963; disc: Cobb, Saunders 1956 and Dorfman 1963
  dropkin_carmi,  ///< cylinder only
  jungnickel,     ///< machine tool rule of thumb, both
};

/// |ΔT| with a floor of 0.1 K rounded up to 0.2 K: natural convection never quite stops and has no corner at ΔT = 0.
template <class Scalar>
Scalar convection_difference_K(const Scalar& difference_K) {
  return floor_at(magnitude(difference_K), 0.1);
}

/// Nu on the diameter of a horizontal cylinder (Churchill, Chu 1975), 1e-5 < Ra < 1e12:
///   Nu = (0.6 + 0.387 Ra^(1/6)/[1 + (0.559/Pr)^(9/16)]^(8/27))²,  Ra = 9.81 ΔT L³ Pr/(T ν²). Cycle-safe.
template <class Scalar>
LawValue<Scalar> natural_cylinder_nusselt(const FluidState<Scalar>& gas, const Scalar& air_K, double diameter_m,
                                          const Scalar& difference_K) {
  using std::pow;
  const Scalar rayleigh = 9.81 * (diameter_m * diameter_m * diameter_m) * difference_K * gas.prandtl /
                          (air_K * square(gas.viscosity_m2_per_s));
  const Scalar divisor = pow(Scalar(1.0 + pow(Scalar(0.559 / gas.prandtl), 9.0 / 16.0)), 8.0 / 27.0);
  return {square(Scalar(0.6 + 0.387 * pow(rayleigh, 1.0 / 6.0) / divisor)), range_flags(rayleigh, 1e-5, 1e12)};
}

/// Nu on the height of a vertical wall (Churchill, Chu 1975), 0.1 < Ra < 1e12:
///   Nu = (0.825 + 0.387 Ra^(1/6)/[1 + (0.492/Pr)^(9/16)]^(8/27))². Cycle-safe.
template <class Scalar>
LawValue<Scalar> natural_wall_nusselt(const FluidState<Scalar>& gas, const Scalar& air_K, double height_m,
                                      const Scalar& difference_K) {
  using std::pow;
  const Scalar rayleigh =
      9.81 * (height_m * height_m * height_m) * difference_K * gas.prandtl / (air_K * square(gas.viscosity_m2_per_s));
  const Scalar divisor = pow(Scalar(1.0 + pow(Scalar(0.492 / gas.prandtl), 9.0 / 16.0)), 8.0 / 27.0);
  return {square(Scalar(0.825 + 0.387 * pow(rayleigh, 1.0 / 6.0) / divisor)), range_flags(rayleigh, 0.1, 1e12)};
}

/// Nu_D of a rotating cylinder in still air, Re = ω D²/(2ν) >= 0: Becker 0.133 Re^(2/3) Pr^(1/3), 1e3 to 4e5.
template <class Scalar>
Scalar becker_nusselt(const Scalar& reynolds, const Scalar& prandtl) {
  using std::pow;
  return 0.133 * pow(reynolds, 2.0 / 3.0) * pow(prandtl, 1.0 / 3.0);
}
/// Dropkin, Carmi 1957, 15000 to 4e5: 0.073 Re^0.7.
template <class Scalar>
Scalar dropkin_carmi_nusselt(const Scalar& reynolds) {
  using std::pow;
  return 0.073 * pow(reynolds, 0.7);
}
/// Jungnickel 2010 [W/m²K]: cylinder 3.75 ω^0.7 r^0.4, disc 2.73 ω^0.8 r^0.6.
template <class Scalar>
Scalar jungnickel_cylinder_W_per_m2K(const Scalar& speed_rad_per_s, double radius_m) {
  using std::pow;
  return 3.75 * pow(speed_rad_per_s, 0.7) * std::pow(radius_m, 0.4);
}
template <class Scalar>
Scalar jungnickel_disc_W_per_m2K(const Scalar& speed_rad_per_s, double radius_m) {
  using std::pow;
  return 2.73 * pow(speed_rad_per_s, 0.8) * std::pow(radius_m, 0.6);
}
/// Mean Nu_r of a rotating disc, Re = ω r²/ν: laminar 0.36 Re^0.5 (below about 5e4), turbulent 0.015 Re^0.8 (above 3e5,
/// or tripped earlier).
template <class Scalar>
Scalar laminar_disc_nusselt(const Scalar& reynolds) {
  using std::pow;
  return 0.36 * pow(reynolds, 0.5);
}
template <class Scalar>
Scalar turbulent_disc_nusselt(const Scalar& reynolds) {
  using std::pow;
  return 0.015 * pow(reynolds, 0.8);
}

struct RotatingSurface {
  RotationFormula formula = RotationFormula::standard;
  double radius_m = 0.0;
};

/// (h_natural³ + h_rotation³)^(1/3) from the two cubes; the cube of the rotation part is smooth through standstill.
template <class Scalar>
Scalar mixed(const Scalar& natural_cubed, const Scalar& rotation_cubed) {
  using std::pow;
  return pow(Scalar(natural_cubed + rotation_cubed), 1.0 / 3.0);
}

/// Film of a rotating cylinder in still air [W/m²K]; air properties at air_K (the film's mean), difference_K = surface
/// minus surrounding air. Standard: Nu³ = Nu_natural³ + Nu_rotation³, even and smooth in speed and in ΔT, natural
/// convection at standstill. As published: rotation alone. The paper prints none. Range: Re 0 to 4e5; Becker itself
/// from 1e3, below it natural convection carries the sum. Cycle-safe.
template <class Scalar>
LawValue<Scalar> rotating_cylinder_W_per_m2K(LawMode mode, const RotatingSurface& surface, const Scalar& speed_rpm,
                                             const Scalar& air_K, const Scalar& difference_K) {
  using std::pow;
  const double D = 2.0 * surface.radius_m;
  const FluidState<Scalar> gas = air(air_K);
  const Scalar omega = magnitude(speed_rpm) * (std::numbers::pi / 30.0);
  const Scalar reynolds = omega * (0.5 * D * D) / gas.viscosity_m2_per_s;
  const Scalar scale = gas.conductivity_W_per_mK / D;
  LawValue<Scalar> result{Scalar(0.0), static_cast<std::uint16_t>(gas.flags | range_flags(reynolds, 0.0, 4e5))};
  Scalar cubed(0.0);  // powers three times as high, so that standstill has a finite slope
  switch (surface.formula) {
    case RotationFormula::standard:
      cubed = cube(Scalar(0.133 * scale)) * square(reynolds) * gas.prandtl;
      break;
    case RotationFormula::dropkin_carmi:
      cubed = cube(Scalar(0.073 * scale)) * pow(reynolds, 2.1);
      break;
    case RotationFormula::jungnickel:
      cubed = std::pow(3.75, 3) * std::pow(surface.radius_m, 1.2) * pow(omega, 2.1);
  }
  if (mode != LawMode::standard) {
    if (real_part(reynolds) > 0.0) result.value = pow(cubed, 1.0 / 3.0);
    result.flags |= range_flags(reynolds, 1e3, 4e5);
    return result;
  }
  const LawValue<Scalar> natural = natural_cylinder_nusselt(gas, air_K, D, convection_difference_K(difference_K));
  result.value = mixed(cube(Scalar(natural.value * scale)), cubed);
  result.flags |= natural.flags;
  return result;
}

/// Film of a rotating disc or end face of radius r [W/m²K], as rotating_cylinder; standard: the larger of the laminar
/// and turbulent law with the corner rounded (e = 0.2), mixed with natural convection on a wall of height r√π. As
/// published: laminar below Re = 3e5, turbulent above. Range: Re to 1e7. Cycle-safe.
template <class Scalar>
LawValue<Scalar> rotating_disc_W_per_m2K(LawMode mode, const RotatingSurface& surface, const Scalar& speed_rpm,
                                         const Scalar& air_K, const Scalar& difference_K) {
  using std::pow;
  const double r = surface.radius_m;
  const FluidState<Scalar> gas = air(air_K);
  const Scalar omega = magnitude(speed_rpm) * (std::numbers::pi / 30.0);
  const Scalar reynolds = omega * (r * r) / gas.viscosity_m2_per_s;
  const Scalar scale = gas.conductivity_W_per_mK / r;
  LawValue<Scalar> result{Scalar(0.0), static_cast<std::uint16_t>(gas.flags | range_flags(reynolds, 0.0, 1e7))};
  if (mode != LawMode::standard) {
    if (surface.formula == RotationFormula::jungnickel) {
      result.value = jungnickel_disc_W_per_m2K(omega, r);
    } else {
      result.value =
          scale * (real_part(reynolds) < 3e5 ? laminar_disc_nusselt(reynolds) : turbulent_disc_nusselt(reynolds));
    }
    return result;
  }
  Scalar cubed(0.0);
  if (surface.formula == RotationFormula::jungnickel) {
    cubed = std::pow(2.73, 3) * std::pow(r, 1.8) * pow(omega, 2.4);
  } else {
    const Scalar laminar = std::pow(0.36, 3) * pow(reynolds, 1.5), turbulent = std::pow(0.015, 3) * pow(reynolds, 2.4);
    cubed = cube(scale) * logmax(laminar, turbulent, 0.6);
  }
  const double height_m = r * std::sqrt(std::numbers::pi);
  const LawValue<Scalar> natural = natural_wall_nusselt(gas, air_K, height_m, convection_difference_K(difference_K));
  result.value = mixed(cube(Scalar(natural.value * gas.conductivity_W_per_mK / height_m)), cubed);
  result.flags |= natural.flags;
  return result;
}

/// Natural convection of a still horizontal cylinder, diameter 2·radius_m [W/m²K]; air_K the film's mean. Cycle-safe.
template <class Scalar>
LawValue<Scalar> still_cylinder_W_per_m2K(double radius_m, const Scalar& air_K, const Scalar& difference_K) {
  const FluidState<Scalar> gas = air(air_K);
  LawValue<Scalar> result = natural_cylinder_nusselt(gas, air_K, 2.0 * radius_m, convection_difference_K(difference_K));
  result.value = result.value * gas.conductivity_W_per_mK / (2.0 * radius_m);
  result.flags |= gas.flags;
  return result;
}

inline constexpr std::array<std::string_view, 3> rotation_formulas = {"standard", "dropkin_carmi", "jungnickel"};

/// What the laws of a cylinder and of a disc have in common.
struct RotatingLaw {
  RotatingSurface surface;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"radius_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.surface.radius_m);
    visit({"formula", {0.0, 2.0, false, false}, false, WrittenUnit::si, rotation_formulas}, law.surface.formula);
  }
};

/// [W/m²K]: first = surface, second = air around it.
struct CylinderLaw : RotatingLaw {
  static constexpr LawTraits traits{"rotating_cylinder", LawRole::conductance, {"surface", "air"}};

  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return rotating_cylinder_W_per_m2K(in.mode, surface, in.speed_rpm, in.mean_K(), Number(in.first_K - in.second_K));
  }
  static CylinderLaw example() { return {{RotationFormula::standard, 0.04}}; }
};

/// Likewise.
struct DiscLaw : RotatingLaw {
  static constexpr LawTraits traits{"rotating_disc", LawRole::conductance, {"surface", "air"}};

  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return rotating_disc_W_per_m2K(in.mode, surface, in.speed_rpm, in.mean_K(), Number(in.first_K - in.second_K));
  }
  static DiscLaw example() { return {{RotationFormula::standard, 0.05}}; }
};

/// Likewise.
struct StillCylinderLaw {
  static constexpr LawTraits traits{"still_cylinder", LawRole::conductance, {"surface", "air"}};
  double radius_m = 0.0;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"radius_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.radius_m);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return still_cylinder_W_per_m2K(radius_m, in.mean_K(), Number(in.first_K - in.second_K));
  }
  static StillCylinderLaw example() { return {0.088}; }
};

}  // namespace spindle_twin::rom
