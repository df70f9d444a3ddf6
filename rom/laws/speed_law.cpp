#include "rom/laws/speed_law.hpp"

#include <cmath>

namespace spindle_twin::rom {

bool is_friction_unless_said(const SpeedLaw& law) { return law.load_squared == 0.0 && !law.speed_terms.empty(); }

double evaluate_speed_law(const SpeedLaw& law, double speed_rpm, double reference_speed_rpm, double load) {
  if (law.zero_at_standstill && speed_rpm == 0.0) return 0.0;
  const double x = std::abs(speed_rpm) / reference_speed_rpm;
  double scale = law.constant + law.load_squared * load * load;
  for (const PowerTerm& term : law.speed_terms) scale += term.coefficient * std::pow(x, term.exponent);
  return scale;
}

}  // namespace spindle_twin::rom
