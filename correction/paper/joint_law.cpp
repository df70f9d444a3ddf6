#include "correction/paper/joint_law.hpp"

#include <algorithm>

#include "rom/laws/interference_fit.hpp"

namespace spindle_twin::correction {

double joint_resistance_ratio(const rom::JointFit& fit, double inner_rise_K, double outer_rise_K, double exponent,
                              double minimum, double maximum) {
  const double pressure_change_Pa =
      fit.pressure_per_inner_rise_Pa_per_K * inner_rise_K - fit.pressure_per_outer_rise_Pa_per_K * outer_rise_K;
  const double pressure_ratio = 1.0 + pressure_change_Pa / fit.assembly_pressure_Pa;
  if (pressure_ratio <= 0.0) return maximum;
  const auto ratio = rom::pressure_resistance_ratio(rom::LawMode::as_published, pressure_ratio, 1.0, exponent);
  return std::clamp(ratio.value, minimum, maximum);
}

}  // namespace spindle_twin::correction
