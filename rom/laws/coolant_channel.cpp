#include "rom/laws/coolant_channel.hpp"

namespace spindle_twin::rom {

double rectangular_laminar_limit(double aspect) {
  const double a = aspect;
  return 7.541 * (1.0 + a * (-2.610 + a * (4.970 + a * (-5.119 + a * (2.702 - 0.548 * a)))));
}

}  // namespace spindle_twin::rom
