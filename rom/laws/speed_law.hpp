#pragma once

#include <vector>

namespace spindle_twin::rom {

/// coefficient · x^exponent, with x = |speed| / reference speed.
struct PowerTerm {
  double coefficient = 0.0;
  double exponent = 0.0;
};

/// Dimensionless factor on a nominal heat or film:
///   scale(x, load) = constant + Σ coefficient_k · x^exponent_k + load_squared · load²,
/// and 0 at standstill if zero_at_standstill. Defaults give the constant 1.
struct SpeedLaw {
  double constant = 1.0;
  std::vector<PowerTerm> speed_terms;
  double load_squared = 0.0;
  bool zero_at_standstill = false;
};

/// Whether a heat of this law counts as friction where its description or file does not say whether it is: the law
/// knows speed, but not load.
bool is_friction_unless_said(const SpeedLaw& law);

/// scale(x, load) of SpeedLaw with x = |speed_rpm| / reference_speed_rpm. Cycle-safe.
double evaluate_speed_law(const SpeedLaw& law, double speed_rpm, double reference_speed_rpm, double load);

}  // namespace spindle_twin::rom
