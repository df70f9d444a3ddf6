#pragma once

#include <numbers>

#include "rom/laws/fluid.hpp"
#include "rom/laws/law.hpp"

namespace spindle_twin::rom {

struct AirGap {
  double rotor_radius_m = 0.0;
  double gap_m = 0.0;                ///< δ₀ at the reference temperature
  double rotor_expansion_per_K = 0;  ///< 0: the gap keeps its width
};

/// Nu of a gap with rotating inner wall (Becker, Kaye 1962), Ta = ω² r δ³/ν²:
///   as published  2 (Ta < 1700), 0.128 Ta^0.367 (< 1e4), 0.409 Ta^0.241 (< 1e7)       jumps of −1.9 % and 0.1 %
///   standard      the larger of 2 and the smaller of the two powers, corners rounded (e = 0.1)
/// Cycle-safe.
template <class Scalar>
LawValue<Scalar> gap_nusselt(LawMode mode, const Scalar& taylor) {
  using std::pow;
  const auto flags = range_flags(taylor, 0.0, 1e7);
  const Scalar vortices = 0.128 * pow(taylor, 0.367), turbulent = 0.409 * pow(taylor, 0.241);
  if (mode == LawMode::standard) return {logmax(Scalar(2.0), logmin(vortices, turbulent, 0.1), 0.1), flags};
  if (real_part(taylor) < 1700.0) return {Scalar(2.0), flags};
  return {real_part(taylor) < 1e4 ? vortices : turbulent, flags};
}

/// Wall-to-wall film of the rotor's air gap [W/m²K]:  h = Nu k/(2δ), δ = δ₀ − a r (T_rotor − T_stator) (not below
/// δ₀/10), air at the mean of both walls. Range: Ta <= 1e7, δ/r <= 0.2. The paper prints none. Cycle-safe.
template <class Scalar>
LawValue<Scalar> air_gap_W_per_m2K(LawMode mode, const AirGap& gap, const Scalar& speed_rpm, const Scalar& rotor_K,
                                   const Scalar& stator_K) {
  const FluidState<Scalar> gas = air(Scalar(0.5 * (rotor_K + stator_K)));
  const Scalar hot = gap.gap_m - gap.rotor_expansion_per_K * gap.rotor_radius_m * (rotor_K - stator_K);
  const Scalar delta = floor_at(hot, 0.1 * gap.gap_m);
  const Scalar omega = speed_rpm * (std::numbers::pi / 30.0);
  const Scalar taylor = square(omega) * gap.rotor_radius_m * cube(delta) / square(gas.viscosity_m2_per_s);
  LawValue<Scalar> result = gap_nusselt(mode, taylor);
  result.value = result.value * gas.conductivity_W_per_mK / (2.0 * delta);
  result.flags |= gas.flags;
  if (real_part(hot) < 0.2 * gap.gap_m || gap.gap_m > 0.2 * gap.rotor_radius_m) result.flags |= shape_out_of_range;
  return result;
}

/// h = k₁ (1 + k₂ v^k₃) [W/m²K] of end windings and cavities, v the rotor's surface speed [m/s] (Staton, Boglietti,
/// Cavagnino 2005); good to a factor of 2: to be calibrated.
struct EndWinding {
  double still_W_per_m2K = 15.0;
  double speed_factor = 0.4;
  double exponent = 0.9;
};

/// Standard: v^k₃ is rounded below 0.1 m/s so that reversal has no cusp. Range: 0 to 100 m/s. Cycle-safe.
template <class Scalar>
LawValue<Scalar> end_winding_W_per_m2K(LawMode mode, const EndWinding& winding, const Scalar& speed_m_per_s) {
  using std::pow;
  const Scalar power = mode == LawMode::standard ? smooth_power(speed_m_per_s, winding.exponent, 0.1)
                                                 : Scalar(pow(magnitude(speed_m_per_s), winding.exponent));
  return {winding.still_W_per_m2K * (1.0 + winding.speed_factor * power),
          range_flags(magnitude(speed_m_per_s), 0.0, 100.0)};
}

/// [W/m²K], wall to wall: first = rotor, second = stator.
struct AirGapLaw {
  static constexpr LawTraits traits{"air_gap", LawRole::conductance, {"rotor", "stator"}};
  AirGap gap;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"rotor_radius_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.gap.rotor_radius_m);
    visit({"gap_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.gap.gap_m);
    visit({"rotor_expansion_per_K", law_ranges::expansion, false, WrittenUnit::si, {}}, law.gap.rotor_expansion_per_K);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return air_gap_W_per_m2K(in.mode, gap, in.speed_rpm, in.first_K, in.second_K);
  }
  static AirGapLaw example() { return {{0.04, 0.0005, 1.17e-5}}; }
};

/// [W/m²K]: speed of the rotor's surface at radius_m.
struct EndWindingLaw {
  static constexpr LawTraits traits{"end_winding", LawRole::conductance};
  EndWinding winding;
  double radius_m = 0.0;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"radius_m", law_ranges::length_m, true, WrittenUnit::mm, {}}, law.radius_m);
    visit({"still_W_per_m2K", law_ranges::above_0, false, WrittenUnit::si, {}}, law.winding.still_W_per_m2K);
    visit({"speed_factor", law_ranges::from_0, false, WrittenUnit::si, {}}, law.winding.speed_factor);
    visit({"exponent", {0.0, 2.0, true, true}, false, WrittenUnit::si, {}}, law.winding.exponent);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return end_winding_W_per_m2K(in.mode, winding, Number(in.speed_rpm * (std::numbers::pi / 30.0 * radius_m)));
  }
  static EndWindingLaw example() { return {{}, 0.04}; }
};

}  // namespace spindle_twin::rom
