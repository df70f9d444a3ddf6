#pragma once

#include "rom/laws/fluid.hpp"
#include "rom/laws/law.hpp"

namespace spindle_twin::rom {

enum class ChannelFormula : std::uint8_t {
  gnielinski,  ///< VDI laminar, Gnielinski turbulent
  paper_trio,  ///< the paper's three formulas, put right: Sieder-Tate, Hausen, Dittus-Boelter
};

struct ChannelShape {
  ChannelFormula formula = ChannelFormula::gnielinski;
  double hydraulic_diameter_m = 0.0;  ///< 4 A/P
  double perimeter_m = 0.0;           ///< P, wetted
  double length_m = 0.0;
  double coil_diameter_m = 0.0;  ///< of a helix; 0: straight
  double laminar_limit = 3.66;   ///< Nusselt number of a long channel; see rectangular_laminar_limit
};

/// Nusselt number of a long rectangular channel of constant wall temperature, aspect = short/long side (Shah, London
/// 1978).
double rectangular_laminar_limit(double aspect);

/// Re at which the flow in a helix turns over (Schmidt 1967): 2300 [1 + 8.6 (d/D)^0.45].
inline double helix_critical_reynolds(double diameter_over_coil) {
  return 2300.0 * (1.0 + 8.6 * std::pow(diameter_over_coil, 0.45));
}

/// Laminar, developing (VDI Heat Atlas, Gnielinski): Nu³ = Nu∞³ + 0.7³ + (1.615 Gz^(1/3) − 0.7)³, Gz = Re Pr D/L.
/// Standard: Gz^(1/3) is an even cubic below Gz = 1 (moves Nu by less than 1 %), so that zero flow has no cusp.
/// Cycle-safe.
template <class Scalar>
Scalar laminar_nusselt(LawMode mode, double limit, const Scalar& graetz) {
  using std::pow;
  const Scalar root =
      mode == LawMode::standard ? smooth_power(graetz, 1.0 / 3.0, 1.0) : Scalar(pow(magnitude(graetz), 1.0 / 3.0));
  const Scalar sum = limit * limit * limit + 0.343 + cube(Scalar(1.615 * root - 0.7));
  return pow(sum, 1.0 / 3.0);
}

/// Turbulent (Gnielinski 1976), 2300 < Re < 5e6, 0.5 < Pr < 2000:
///   Nu = (f/8)(Re − 1000) Pr/(1 + 12.7 √(f/8)(Pr^(2/3) − 1)) [1 + (D/L)^(2/3)],  f = (0.79 ln Re − 1.64)^−2.
///   Cycle-safe.
template <class Scalar>
Scalar turbulent_nusselt(const Scalar& reynolds, const Scalar& prandtl, double diameter_over_length) {
  using std::log;
  using std::pow;
  const Scalar root_f8 = 1.0 / ((0.79 * log(reynolds) - 1.64) * std::sqrt(8.0));
  const Scalar top = square(root_f8) * (reynolds - 1000.0) * prandtl;
  return top / (1.0 + 12.7 * root_f8 * (pow(prandtl, 2.0 / 3.0) - 1.0)) *
         (1.0 + std::pow(diameter_over_length, 2.0 / 3.0));
}

template <class Scalar>
Scalar sieder_tate_nusselt(const Scalar& graetz) {
  using std::pow;
  return 1.86 * pow(graetz, 1.0 / 3.0);
}
template <class Scalar>
Scalar hausen_nusselt(const Scalar& reynolds, const Scalar& prandtl, double diameter_over_length) {
  using std::pow;
  return 0.116 * (pow(reynolds, 2.0 / 3.0) - 125.0) * pow(prandtl, 1.0 / 3.0) *
         (1.0 + std::pow(diameter_over_length, 2.0 / 3.0));
}
template <class Scalar>
Scalar dittus_boelter_nusselt(const Scalar& reynolds, const Scalar& prandtl) {
  using std::pow;
  return 0.023 * pow(reynolds, 0.8) * pow(prandtl, 0.4);
}

/// The paper's three formulas in their right order and with their lost constants: 1.86 (Re < 2200), 0.116, 0.023 (>
/// 1e4); standard mixes them within ±10 % of both limits in ln Re. Sieder-Tate falls to nothing in long channels
/// (below_range of channel_nusselt where Gz < 8).
template <class Scalar>
Scalar trio_nusselt(LawMode mode, const Scalar& reynolds, const Scalar& prandtl, double diameter_over_length);

/// Nu of a channel, Re >= 0 on D:
///   gnielinski, standard      (1 − w) Nu_lam + w Nu_turb, w = smoothstep(Re; 2300, 4000)
///   gnielinski, as published  linear between Nu_lam(2300) and Nu_turb(4000) (Gnielinski 2013): a corner of slope at
///   both helix                     w from helix_critical_reynolds to 2.2e4, Nu_turb times 1 + 3.6 (1 − d/D)(d/D)^0.8
///   paper_trio                trio_nusselt
/// Cycle-safe.
template <class Scalar>
LawValue<Scalar> channel_nusselt(LawMode mode, const ChannelShape& shape, const Scalar& reynolds,
                                 const Scalar& prandtl) {
  const double ratio = shape.hydraulic_diameter_m / shape.length_m;
  LawValue<Scalar> result{Scalar(0.0), range_flags(reynolds, 0.0, 5e6)};
  result.flags |= range_flags(prandtl, 0.5, 2000.0);
  if (shape.formula == ChannelFormula::paper_trio) {
    result.value = trio_nusselt(mode, reynolds, prandtl, ratio);
    if (real_part(reynolds) < 2200.0) result.flags |= range_flags(Scalar(reynolds * prandtl * ratio), 8.0, 1e9);
    return result;
  }
  double low = 2300.0, high = 4000.0, swirl = 1.0;
  if (shape.coil_diameter_m > 0.0) {
    const double curvature = shape.hydraulic_diameter_m / shape.coil_diameter_m;
    low = helix_critical_reynolds(curvature);
    high = 2.2e4;
    if (low >= high) high = 1.5 * low;
    swirl = 1.0 + 3.6 * (1.0 - curvature) * std::pow(curvature, 0.8);
  }
  const auto laminar = [&](const Scalar& Re) {
    return laminar_nusselt(mode, shape.laminar_limit, Scalar(Re * prandtl * ratio));
  };
  const auto turbulent = [&](const Scalar& Re) { return swirl * turbulent_nusselt(Re, prandtl, ratio); };
  if (real_part(reynolds) <= low) {
    result.value = laminar(reynolds);
  } else if (real_part(reynolds) >= high) {
    result.value = turbulent(reynolds);
  } else if (mode == LawMode::standard) {
    const Scalar w = smoothstep(reynolds, low, high);
    result.value = (1.0 - w) * laminar(reynolds) + w * turbulent(reynolds);
  } else {
    const Scalar w = (reynolds - low) / (high - low);
    result.value = (1.0 - w) * laminar(Scalar(low)) + w * turbulent(Scalar(high));
  }
  return result;
}

template <class Scalar>
Scalar trio_nusselt(LawMode mode, const Scalar& reynolds, const Scalar& prandtl, double diameter_over_length) {
  using std::log;
  const double Re = real_part(reynolds);
  const Scalar graetz = reynolds * prandtl * diameter_over_length;
  if (mode != LawMode::standard) {
    if (Re < 2200.0) return sieder_tate_nusselt(graetz);
    if (Re <= 1e4) return hausen_nusselt(reynolds, prandtl, diameter_over_length);
    return dittus_boelter_nusselt(reynolds, prandtl);
  }
  const double band = std::log(1.1);
  const Scalar laminar = 1.86 * smooth_power(graetz, 1.0 / 3.0, 1.0);
  if (Re < 2200.0 / 1.1) return laminar;
  const Scalar middle = hausen_nusselt(reynolds, prandtl, diameter_over_length);
  const Scalar lnRe = log(reynolds);
  const Scalar first = smoothstep(lnRe, std::log(2200.0) - band, std::log(2200.0) + band);
  const Scalar last = smoothstep(lnRe, std::log(1e4) - band, std::log(1e4) + band);
  const Scalar lower = laminar + first * (middle - laminar);
  return lower + last * (dittus_boelter_nusselt(reynolds, prandtl) - lower);
}

/// The paper's section on the jacket word for word [W/m²K], its "characteristic length" L = length_m:
///   Re < 2200    (λ/L)(1.86 Re Pr D/L)^(1/3)                       1.86 belongs before the root, λ/D for λ/L
///   Re <= 1e4    (λ/L) 0.023 Re^0.8 Pr^0.4                         exchanged with the next
///   Re > 1e4     (λ/L)(Re^(2/3) − 125) Pr^(1/3) (1 + D/L)^(2/3)    0.116 lost, exponent misplaced
template <class Scalar>
Scalar printed_channel_film_W_per_m2K(const ChannelShape& shape, const Scalar& reynolds, const Scalar& prandtl,
                                      const Scalar& conductivity_W_per_mK) {
  using std::pow;
  const double ratio = shape.hydraulic_diameter_m / shape.length_m;
  const Scalar scale = conductivity_W_per_mK / shape.length_m;
  if (real_part(reynolds) < 2200.0) return scale * pow(Scalar(1.86 * reynolds * prandtl * ratio), 1.0 / 3.0);
  if (real_part(reynolds) < 1e4) return scale * dittus_boelter_nusselt(reynolds, prandtl);
  return scale * (pow(reynolds, 2.0 / 3.0) - 125.0) * pow(prandtl, 1.0 / 3.0) * std::pow(1.0 + ratio, 2.0 / 3.0);
}

/// Film coefficient of a channel [W/m²K]:  h = Nu k/D · (Pr/Pr_wall)^0.11, Re = 4|ṁ|/(P μ); bulk properties at
/// liquid_K, the wall's Prandtl number at wall_K (not in the paper's formulas). Outside the liquid's range its
/// properties are held (temperature_clamped). Cycle-safe.
template <class Scalar>
LawValue<Scalar> channel_film_W_per_m2K(LawMode mode, const ChannelShape& shape, const Liquid& liquid,
                                        const Scalar& flow_kg_per_s, const Scalar& wall_K, const Scalar& liquid_K) {
  using std::pow;
  const FluidState<Scalar> bulk = liquid_state(liquid, liquid_K);
  const Scalar reynolds = 4.0 * magnitude(flow_kg_per_s) / (shape.perimeter_m * bulk.viscosity_Pa_s);
  if (mode == LawMode::as_printed) {
    return {printed_channel_film_W_per_m2K(shape, reynolds, bulk.prandtl, bulk.conductivity_W_per_mK), bulk.flags};
  }
  LawValue<Scalar> result = channel_nusselt(mode, shape, reynolds, bulk.prandtl);
  result.value = result.value * bulk.conductivity_W_per_mK / shape.hydraulic_diameter_m;
  result.flags |= bulk.flags;
  if (shape.formula == ChannelFormula::gnielinski) {
    const FluidState<Scalar> wall = liquid_state(liquid, wall_K);
    result.value *= pow(Scalar(bulk.prandtl / wall.prandtl), 0.11);
    result.flags |= wall.flags;
  }
  return result;
}

inline constexpr std::array<std::string_view, 2> channel_formulas = {"gnielinski", "paper_trio"};

/// [W/m²K]: first = wall, second = liquid. The channel law makes the segment's effective value of it.
struct ChannelLaw {
  static constexpr LawTraits traits{"channel", LawRole::channel, {"wall", "liquid"}};
  ChannelShape shape;
  Liquid liquid;

  template <class Law, class Visit>
  static void each(Law& law, Visit&& visit) {
    using enum WrittenUnit;
    visit({"formula", {0.0, 1.0, false, false}, false, si, channel_formulas}, law.shape.formula);
    visit({"hydraulic_diameter_m", law_ranges::length_m, true, mm, {}}, law.shape.hydraulic_diameter_m);
    visit({"perimeter_m", law_ranges::length_m, true, mm, {}}, law.shape.perimeter_m);
    visit({"length_m", law_ranges::length_m, true, mm, {}}, law.shape.length_m);
    visit({"coil_diameter_m", {0.0, 1e3, false, false}, false, mm, {}}, law.shape.coil_diameter_m);
    visit({"laminar_limit", {0.1, 100.0, false, false}, false, si, {}}, law.shape.laminar_limit);
    visit({"liquid_viscosity_Pa_s", law_ranges::above_0, false, si, {}}, law.liquid.viscosity_Pa_s);
    visit({"liquid_vogel_K", {0.0, 1e4, false, false}, false, si, {}}, law.liquid.vogel_K);
    visit({"liquid_vogel_zero_K", {0.0, 1e4, false, false}, false, si, {}}, law.liquid.vogel_zero_K);
    visit({"liquid_conductivity_W_per_mK", law_ranges::any, false, si, {}}, law.liquid.conductivity_W_per_mK);
    visit({"liquid_conductivity_slope_W_per_mK2", law_ranges::any, false, si, {}},
          law.liquid.conductivity_slope_W_per_mK2);
    visit({"liquid_conductivity_curve_W_per_mK3", law_ranges::any, false, si, {}},
          law.liquid.conductivity_curve_W_per_mK3);
    visit({"liquid_density_kg_per_m3", law_ranges::above_0, false, si, {}}, law.liquid.density_kg_per_m3);
    visit({"liquid_heat_capacity_J_per_kgK", law_ranges::above_0, false, si, {}}, law.liquid.heat_capacity_J_per_kgK);
    visit({"liquid_coldest_K", law_ranges::kelvin, false, degC, {}}, law.liquid.coldest_K);
    visit({"liquid_hottest_K", law_ranges::kelvin, false, degC, {}}, law.liquid.hottest_K);
  }
  std::string_view fault() const {
    if (liquid.coldest_K + 2.0 < liquid.hottest_K && liquid.vogel_zero_K < liquid.coldest_K) return {};
    return "liquid_coldest_K: must lie above vogel_zero_K and 2 K below hottest_K";
  }
  template <class Number>
  LawValue<Number> value(const LawInputs<Number>& in) const {
    return channel_film_W_per_m2K(in.mode, shape, liquid, in.flow_kg_per_s, in.first_K, in.second_K);
  }
  static ChannelLaw example() {
    ChannelLaw law;
    law.shape.hydraulic_diameter_m = 0.008;
    law.shape.perimeter_m = 0.0251;
    law.shape.length_m = 3.0;
    return law;
  }
};

}  // namespace spindle_twin::rom
