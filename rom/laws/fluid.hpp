#pragma once

#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

template <class Scalar>
struct FluidState {
  Scalar density_kg_per_m3{};
  Scalar viscosity_Pa_s{};
  Scalar viscosity_m2_per_s{};  ///< kinematic
  Scalar conductivity_W_per_mK{};
  Scalar prandtl{};
  std::uint16_t flags = in_range;
};

/// Dry air at 1 atm, 200 to 600 K, held constant outside (temperature_clamped):
///   μ = 1.716e-5 (T/273.15)^1.5 (273.15 + 110.4)/(T + 110.4)     Sutherland 1893
///   ρ = 101325/(287.05 T),  k = 0.0241 (T/273.15)^0.9,  Pr = 0.707
/// k and Pr are fits, within 1 % from 250 to 400 K. Cycle-safe.
template <class Scalar>
FluidState<Scalar> air(const Scalar& temperature_K) {
  using std::pow;
  constexpr double low_K = 200.0, high_K = 600.0;
  const Scalar T = soft_limit(temperature_K, low_K, high_K, 2.0);
  FluidState<Scalar> state;
  state.viscosity_Pa_s = 1.716e-5 * pow(Scalar(T / 273.15), 1.5) * (273.15 + 110.4) / (T + 110.4);
  state.density_kg_per_m3 = 101325.0 / (287.05 * T);
  state.viscosity_m2_per_s = state.viscosity_Pa_s / state.density_kg_per_m3;
  state.conductivity_W_per_mK = 0.0241 * pow(Scalar(T / 273.15), 0.9);
  state.prandtl = Scalar(0.707);
  if (range_flags(temperature_K, low_K, high_K) != in_range) state.flags = temperature_clamped;
  return state;
}

/// A coolant: μ = viscosity_Pa_s · 10^(vogel_K/(T − vogel_zero_K)) (Vogel 1921), k quadratic in T, ρ and c constant.
/// Defaults: water, 275 to 370 K, k fit of handbook values within 0.5 %; density that of 27 °C, 4 % high at 95 °C.
struct Liquid {
  double viscosity_Pa_s = 2.414e-5;
  double vogel_K = 247.8;
  double vogel_zero_K = 140.0;
  double conductivity_W_per_mK = -0.5752;
  double conductivity_slope_W_per_mK2 = 6.397e-3;
  double conductivity_curve_W_per_mK3 = -8.151e-6;
  double density_kg_per_m3 = 996.5;
  double heat_capacity_J_per_kgK = 4179.0;
  double coldest_K = 275.0;
  double hottest_K = 370.0;
};

/// Properties of `liquid`, held constant outside its range (temperature_clamped). Cycle-safe.
template <class Scalar>
FluidState<Scalar> liquid_state(const Liquid& liquid, const Scalar& temperature_K) {
  using std::exp;
  const Scalar T = soft_limit(temperature_K, liquid.coldest_K, liquid.hottest_K, 1.0);
  FluidState<Scalar> state;
  state.viscosity_Pa_s = liquid.viscosity_Pa_s * exp(std::log(10.0) * liquid.vogel_K / (T - liquid.vogel_zero_K));
  state.density_kg_per_m3 = Scalar(liquid.density_kg_per_m3);
  state.viscosity_m2_per_s = state.viscosity_Pa_s / liquid.density_kg_per_m3;
  state.conductivity_W_per_mK = liquid.conductivity_W_per_mK +
                                T * (liquid.conductivity_slope_W_per_mK2 + liquid.conductivity_curve_W_per_mK3 * T);
  state.prandtl = state.viscosity_Pa_s * liquid.heat_capacity_J_per_kgK / state.conductivity_W_per_mK;
  if (range_flags(temperature_K, liquid.coldest_K, liquid.hottest_K) != in_range) state.flags = temperature_clamped;
  return state;
}

/// Walther's law, ASTM D341: lg lg(ν + 0.7) = A − B lg T, ν in mm²/s, T in K.
struct Lubricant {
  double walther_a = 0.0;
  double walther_b = 0.0;
};

/// Through two points of the oil's data sheet, both viscosities above 0.3 mm²/s. Host side.
Lubricant lubricant_through(double first_K, double first_m2_per_s, double second_K, double second_m2_per_s);

/// ν [m²/s]. Standard: T held inside −20 to 150 °C (temperature_clamped); as published: no limit. thin_film below
/// 2 mm²/s, where D341 needs further terms. dν/dT = −B Z ln Z / T · 1e-6, Z = ν + 0.7 mm²/s. Cycle-safe.
template <class Scalar>
LawValue<Scalar> lubricant_viscosity_m2_per_s(LawMode mode, const Lubricant& oil, const Scalar& temperature_K) {
  using std::exp;
  using std::log;
  constexpr double low_K = 253.15, high_K = 423.15;
  const Scalar T = mode == LawMode::standard ? soft_limit(temperature_K, low_K, high_K, 2.0) : temperature_K;
  const double ln10 = std::log(10.0);
  const Scalar lg = exp(ln10 * oil.walther_a - oil.walther_b * log(T));  // lg(ν + 0.7)
  LawValue<Scalar> result{(exp(ln10 * lg) - 0.7) * 1e-6, in_range};
  if (range_flags(temperature_K, low_K, high_K) != in_range) result.flags |= temperature_clamped;
  if (real_part(result.value) < 2e-6) result.flags |= thin_film;
  return result;
}

/// Reynolds' law ν = ν₀ exp(−b (T − T₀)), good for ±15 K only: for comparison. Cycle-safe.
template <class Scalar>
Scalar reynolds_viscosity_m2_per_s(double nu0_m2_per_s, double b_per_K, double at_K, const Scalar& temperature_K) {
  using std::exp;
  return nu0_m2_per_s * exp(-b_per_K * (temperature_K - at_K));
}

}  // namespace spindle_twin::rom
