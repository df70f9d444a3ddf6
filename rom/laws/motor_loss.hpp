#pragma once

#include <cmath>
#include <numbers>

#include "rom/laws/law.hpp"
#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

struct CopperLoss {
  double phases = 3.0;
  double resistance_20_ohm = 0.0;         ///< of one phase at 20 °C
  double temperature_per_K = 0.00393;     ///< copper; 1/255 in the form of IEC 60034-1
  double ac_ratio = 1.0;                  ///< k_ac = R_ac/R_dc at 20 °C
  double printed_resistivity = 1.724e-8;  ///< Ω m
};

/// P = m I² R₂₀ (x + (k_ac − 1)/x), x = 1 + a (T − 20 °C): the proximity part falls as the metal's resistance rises.
/// I is the rms current of a phase. As published: m I² R₂₀ k_ac, no temperature. As printed: ρ I² R of one phase, in
/// which the resistivity stands twice (1e-8 of the right value). Standard keeps x >= 0.1. Range: −50 to 220 °C.
/// Cycle-safe.
template <class Scalar>
LawValue<Scalar> copper_loss_W(LawMode mode, const CopperLoss& copper, const Scalar& current_A,
                               const Scalar& temperature_K) {
  const Scalar direct = square(current_A) * copper.resistance_20_ohm;
  if (mode == LawMode::as_printed) return {copper.printed_resistivity * direct, in_range};
  if (mode == LawMode::as_published) return {copper.phases * copper.ac_ratio * direct, in_range};
  const Scalar raw = 1.0 + copper.temperature_per_K * (temperature_K - 293.15);
  const Scalar x = 0.1 + ramp(Scalar(raw - 0.1), 0.1);
  LawValue<Scalar> result{copper.phases * direct * (x + (copper.ac_ratio - 1.0) / x), in_range};
  if (range_flags(temperature_K, 223.15, 493.15) != in_range) result.flags = temperature_clamped;
  return result;
}

/// Bertotti's separation with the coefficients of one convention: p_eddy = π² d² f² B²/(6 ρ_e ρ_m) for sinusoidal B of
/// peak value B (some programs take 2π² out of the coefficient).
struct IronLoss {
  double hysteresis = 0.02;  ///< k_h, W/kg/(Hz T^a)
  double excess = 0.0;       ///< k_x, W/kg/(Hz T)^1.5
  double lamination_m = 0.35e-3;
  double resistivity_ohm_m = 5.2e-7;
  double density_kg_per_m3 = 7650.0;
  double relative_permeability = 1000.0;
  double mass_kg = 1.0;
  double build_factor = 1.0;  ///< 1.5 to 2 for cutting and pressing
};

/// F(x) = (3/x)(sinh x − sin x)/(cosh x − cos x), x = d √(π f μ/ρ_e) >= 0: what is left of the eddy loss once the
/// field no longer fills the lamination. 1 at 0, 3/x at infinity. Cycle-safe.
template <class Scalar>
Scalar skin_factor(const Scalar& x) {
  using std::cos;
  using std::cosh;
  using std::sin;
  using std::sinh;
  if (real_part(x) < 0.3) {  // the quotient of the series; the differences above cancel there
    const Scalar x4 = square(square(x));
    return (1.0 + x4 / 840.0 + x4 * x4 / 6652800.0) / (1.0 + x4 / 360.0 + x4 * x4 / 1814400.0);
  }
  if (real_part(x) > 40.0) return 3.0 / x;
  return 3.0 / x * (sinh(x) - sin(x)) / (cosh(x) - cos(x));
}

/// π² d² f² B²/(6 ρ_e ρ_m) [W/kg], Standard: times the skin factor. As printed π instead of π². Cycle-safe.
template <class Scalar>
Scalar eddy_loss_W_per_kg(LawMode mode, const IronLoss& iron, const Scalar& frequency_Hz, const Scalar& flux_T) {
  using std::sqrt;
  constexpr double pi = std::numbers::pi;
  const double coefficient =
      iron.lamination_m * iron.lamination_m / (6.0 * iron.resistivity_ohm_m * iron.density_kg_per_m3);
  const Scalar loss = coefficient * square(Scalar(frequency_Hz * flux_T));
  if (mode == LawMode::as_printed) return pi * loss;
  if (mode == LawMode::as_published || real_part(frequency_Hz) == 0.0) return pi * pi * loss;
  const double permeability = 4e-7 * pi * iron.relative_permeability;
  const Scalar x = iron.lamination_m * sqrt(magnitude(frequency_Hz) * (pi * permeability / iron.resistivity_ohm_m));
  return pi * pi * loss * skin_factor(x);
}

/// k_h f B^a [W/kg], a = 1.6 for B < 1 T and 2 above (Steinmetz); standard: a moves from 1.6 at 0.8 T to 2 at 1.2 T,
/// and |f| is rounded within 0.1 Hz so that reversal has no corner. Cycle-safe.
template <class Scalar>
Scalar hysteresis_loss_W_per_kg(LawMode mode, const IronLoss& iron, const Scalar& frequency_Hz, const Scalar& flux_T) {
  using std::exp;
  using std::log;
  if (real_part(flux_T) <= 0.0) return Scalar(0.0);
  if (mode != LawMode::standard) {
    const double exponent = real_part(flux_T) < 1.0 ? 1.6 : 2.0;
    return iron.hysteresis * magnitude(frequency_Hz) * exp(exponent * log(flux_T));
  }
  const Scalar exponent = 1.6 + 0.4 * smoothstep(flux_T, 0.8, 1.2);
  return iron.hysteresis * smooth_power(frequency_Hz, 1.0, 0.1) * exp(exponent * log(flux_T));
}

/// k_x |f B|^1.5 [W/kg] (Bertotti 1988). Cycle-safe.
template <class Scalar>
Scalar excess_loss_W_per_kg(const IronLoss& iron, const Scalar& frequency_Hz, const Scalar& flux_T) {
  using std::pow;
  return iron.excess * pow(magnitude(Scalar(frequency_Hz * flux_T)), 1.5);
}

/// Loss of the core [W]: mass · build_factor · (hysteresis + eddy + excess), without excess as printed.
/// Range: 0 <= f <= 2 kHz, 0 <= B <= 2 T. Cycle-safe.
template <class Scalar>
LawValue<Scalar> iron_loss_W(LawMode mode, const IronLoss& iron, const Scalar& frequency_Hz, const Scalar& flux_T) {
  Scalar loss =
      eddy_loss_W_per_kg(mode, iron, frequency_Hz, flux_T) + hysteresis_loss_W_per_kg(mode, iron, frequency_Hz, flux_T);
  if (mode != LawMode::as_printed) loss += excess_loss_W_per_kg(iron, frequency_Hz, flux_T);
  const auto flags =
      static_cast<std::uint16_t>(range_flags(magnitude(frequency_Hz), 0.0, 2000.0) | range_flags(flux_T, 0.0, 2.0));
  return {iron.mass_kg * iron.build_factor * loss, flags};
}

/// Flux in the core [T]: base_T up to the base speed, base_T · n_b/|n| above (field weakening), corner rounded over
/// ±10 %. Cycle-safe.
template <class Scalar>
Scalar core_flux_T(double base_T, double base_speed_rpm, const Scalar& speed_rpm) {
  return base_T / logmax(Scalar(1.0), Scalar(magnitude(speed_rpm) / base_speed_rpm), 0.1);
}

/// [W]: first = winding.
struct CopperLaw {
  static constexpr LawTraits traits{"copper_loss", LawRole::heat, {"winding", ""}, MeasuredDrive::current};
  CopperLoss copper;
  double rated_current_A = 0.0;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"resistance_20_ohm", law_ranges::above_0, true, si, {}}, law.copper.resistance_20_ohm);
    visit({"rated_current_A", law_ranges::from_0, true, si, {}}, law.rated_current_A);
    visit({"phases", {1.0, 100.0, false, false}, false, si, {}}, law.copper.phases);
    visit({"temperature_per_K", {0.0, 0.1, false, false}, false, si, {}}, law.copper.temperature_per_K);
    visit({"ac_ratio", {1.0, 1e3, false, false}, false, si, {}}, law.copper.ac_ratio);
    visit({"printed_resistivity", law_ranges::from_0, false, si, {}}, law.copper.printed_resistivity);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return copper_loss_W(in.mode, copper, Number(in.state.current_A.value_or(rated_current_A * in.state.load)),
                         in.first_K);
  }
  static CopperLaw example() {
    CopperLaw law;
    law.copper.resistance_20_ohm = 0.35;
    law.rated_current_A = 20.0;
    return law;
  }
};

/// The motor's loss as a whole [W]: (1 − efficiency) |P|, P its electrical power. Depends on no temperature.
struct MotorEfficiencyLaw {
  static constexpr LawTraits traits{"motor_efficiency", LawRole::heat, {}, MeasuredDrive::power};
  double efficiency = 0.9;
  double rated_power_W = 0.0;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    visit({"efficiency", {0.0, 1.0, true, false}, true, WrittenUnit::si, {}}, law.efficiency);
    visit({"rated_power_W", law_ranges::from_0, true, WrittenUnit::si, {}}, law.rated_power_W);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    const double power_W = std::abs(in.state.power_W.value_or(rated_power_W * in.state.load));
    return {Number((1.0 - efficiency) * power_W), in_range};
  }
  static MotorEfficiencyLaw example() { return {0.92, 9000.0}; }
};

/// [W]: f = pole_pairs n/60 + slip. Depends on no temperature.
struct IronLaw {
  static constexpr LawTraits traits{"iron_loss", LawRole::heat};
  IronLoss iron;
  double pole_pairs = 1.0;
  double slip_Hz = 0.0;
  double base_flux_T = 1.0;
  double base_speed_rpm = 1e9;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"core_mass_kg", law_ranges::above_0, true, si, {}}, law.iron.mass_kg);
    visit({"pole_pairs", {1.0, 1e3, false, false}, true, si, {}}, law.pole_pairs);
    visit({"base_flux_T", {0.0, 10.0, false, false}, true, si, {}}, law.base_flux_T);
    visit({"base_speed_rpm", law_ranges::above_0, true, si, {}}, law.base_speed_rpm);
    visit({"slip_Hz", {0.0, 1e4, false, false}, false, si, {}}, law.slip_Hz);
    visit({"hysteresis", law_ranges::from_0, false, si, {}}, law.iron.hysteresis);
    visit({"excess", law_ranges::from_0, false, si, {}}, law.iron.excess);
    visit({"lamination_m", law_ranges::length_m, false, mm, {}}, law.iron.lamination_m);
    visit({"resistivity_ohm_m", law_ranges::above_0, false, si, {}}, law.iron.resistivity_ohm_m);
    visit({"density_kg_per_m3", law_ranges::above_0, false, si, {}}, law.iron.density_kg_per_m3);
    visit({"relative_permeability", law_ranges::above_0, false, si, {}}, law.iron.relative_permeability);
    visit({"build_factor", law_ranges::above_0, false, si, {}}, law.iron.build_factor);
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    const Number frequency_Hz = pole_pairs / 60.0 * in.speed_rpm + slip_Hz;
    return iron_loss_W(in.mode, iron, frequency_Hz, core_flux_T(base_flux_T, base_speed_rpm, in.speed_rpm));
  }
  static IronLaw example() { return {{}, 2.0, 3.0, 1.1, 6000.0}; }
};

}  // namespace spindle_twin::rom
