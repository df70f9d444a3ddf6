#pragma once

#include "rom/laws/law.hpp"
#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

/// Two thick-walled rings pressed together: inner a < b, outer b < c.
struct InterferenceFit {
  double bore_radius_m = 0.0;   ///< a, 0 for a solid shaft
  double joint_radius_m = 0.0;  ///< b
  double outer_radius_m = 0.0;  ///< c
  double inner_young_Pa = 0.0;
  double inner_poisson = 0.0;
  double inner_expansion_per_K = 0.0;
  double outer_young_Pa = 0.0;
  double outer_poisson = 0.0;
  double outer_expansion_per_K = 0.0;
  double interference_m = 0.0;    ///< d₀, radial, at assembly; negative: clearance
  double centrifugal_m_s2 = 0.0;  ///< radial interference lost per ω²
  double corner_m = 1e-7;         ///< interference over which pressing turns into a gap

  /// As a law lists its numbers.
  template <class Fit, class Visit>
  static void each(Fit& fit, Visit&& visit) {
    using enum WrittenUnit;
    visit({"fit_bore_radius_m", {0.0, 1e3, false, false}, true, mm, {}}, fit.bore_radius_m);
    visit({"fit_joint_radius_m", law_ranges::length_m, true, mm, {}}, fit.joint_radius_m);
    visit({"fit_outer_radius_m", law_ranges::length_m, true, mm, {}}, fit.outer_radius_m);
    visit({"fit_interference_m", {-0.1, 0.1, false, false}, true, um, {}}, fit.interference_m);
    visit({"fit_inner_young_Pa", law_ranges::above_0, true, si, {}}, fit.inner_young_Pa);
    visit({"fit_inner_poisson", {0.0, 0.5, false, true}, true, si, {}}, fit.inner_poisson);
    visit({"fit_inner_expansion_per_K", law_ranges::expansion, true, si, {}}, fit.inner_expansion_per_K);
    visit({"fit_outer_young_Pa", law_ranges::above_0, true, si, {}}, fit.outer_young_Pa);
    visit({"fit_outer_poisson", {0.0, 0.5, false, true}, true, si, {}}, fit.outer_poisson);
    visit({"fit_outer_expansion_per_K", law_ranges::expansion, true, si, {}}, fit.outer_expansion_per_K);
    visit({"fit_centrifugal_m_s2", law_ranges::from_0, false, si, {}}, fit.centrifugal_m_s2);
    visit({"fit_corner_m", {1e-12, 1e-3, false, false}, false, um, {}}, fit.corner_m);
  }
};

/// Pressure per radial interference [Pa/m] (Lamé 1852):
///   p/d = 1/( b [ ((c²+b²)/(c²−b²) + ν_o)/E_o + ((b²+a²)/(b²−a²) − ν_i)/E_i ] )
inline double fit_stiffness_Pa_per_m(const InterferenceFit& fit) {
  const double a2 = fit.bore_radius_m * fit.bore_radius_m, b2 = fit.joint_radius_m * fit.joint_radius_m,
               c2 = fit.outer_radius_m * fit.outer_radius_m;
  const double outer = ((c2 + b2) / (c2 - b2) + fit.outer_poisson) / fit.outer_young_Pa;
  const double inner = ((b2 + a2) / (b2 - a2) - fit.inner_poisson) / fit.inner_young_Pa;
  return 1.0 / (fit.joint_radius_m * (outer + inner));
}

template <class Scalar>
struct FitState {
  Scalar pressure_Pa{};
  Scalar gap_m{};  ///< clearance, 0 while the rings press
  std::uint16_t flags = in_range;
};

/// d = d₀ + b (a_i ΔT_i − a_o ΔT_o) − centrifugal ω², p = stiffness · max(d, 0), gap = max(−d, 0); corners rounded
/// within ± corner_m unless as published. Rises of the two bodies since assembly. Cycle-safe.
template <class Scalar>
FitState<Scalar> fit_state(LawMode mode, const InterferenceFit& fit, const Scalar& inner_rise_K,
                           const Scalar& outer_rise_K, const Scalar& speed_rad_per_s) {
  const Scalar d =
      fit.interference_m +
      fit.joint_radius_m * (fit.inner_expansion_per_K * inner_rise_K - fit.outer_expansion_per_K * outer_rise_K) -
      fit.centrifugal_m_s2 * square(speed_rad_per_s);
  const double stiffness = fit_stiffness_Pa_per_m(fit);
  const auto flags = real_part(d) <= 0.0 ? joint_open : in_range;
  if (mode == LawMode::standard) {
    return {stiffness * ramp(d, fit.corner_m), ramp(Scalar(-d), fit.corner_m), flags};
  }
  if (real_part(d) > 0.0) return {stiffness * d, Scalar(0.0), flags};
  return {Scalar(0.0), -d, flags};
}

/// R'/R of a joint whose pressure went from p₀ to p: (p/p₀)^−exponent. Standard: held inside [0.1, 10] with corners
/// rounded over a factor e^0.1, 10 at p <= 0. As published without limits. Cycle-safe.
template <class Scalar>
LawValue<Scalar> pressure_resistance_ratio(LawMode mode, const Scalar& pressure_Pa, double assembly_pressure_Pa,
                                           double exponent = 0.68) {
  using std::exp;
  using std::log;
  if (real_part(pressure_Pa) <= 0.0) return {Scalar(10.0), joint_open};
  const Scalar logarithm = -exponent * log(pressure_Pa / assembly_pressure_Pa);
  if (mode != LawMode::standard) return {exp(logarithm), in_range};
  const double limit = std::log(10.0);
  const auto flags = std::abs(real_part(logarithm)) > limit ? above_range : in_range;
  return {exp(soft_limit(logarithm, -limit, limit, 0.1)), flags};
}

/// The paper's correction word for word:  R'/R = 1 + (P/(E A (√((1 + 3aΔt)/(1 + aΔt)) − 1)))^0.68.
/// It depends on the unit of A, only ever lets the resistance grow, and has no value for Δt <= 0 (undefined: 1 is
/// returned) and a pole at 0. For comparison only. Cycle-safe.
template <class Scalar>
LawValue<Scalar> printed_resistance_ratio(const Scalar& rise_difference_K, double pressure, double young, double area,
                                          double expansion_per_K) {
  using std::pow;
  using std::sqrt;
  const Scalar x = expansion_per_K * rise_difference_K;
  // √((1+3x)/(1+x)) − 1 = 2x/((1+x)(√(…) + 1)): no cancellation
  if (real_part(x) <= 0.0) return {Scalar(1.0), undefined};
  const Scalar strain = 2.0 * x / ((1.0 + x) * (sqrt((1.0 + 3.0 * x) / (1.0 + x)) + 1.0));
  return {1.0 + pow(Scalar(pressure / (young * area * strain)), 0.68), in_range};
}

}  // namespace spindle_twin::rom
