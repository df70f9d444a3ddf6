#include "correction/laws/channel_law.hpp"

#include <cmath>

namespace spindle_twin::correction {

double channel_W_per_m2K(double film_W_per_m2K, double area_m2, double flow_W_per_K) {
  if (flow_W_per_K == 0.0) return 0.0;
  return -flow_W_per_K * std::expm1(-film_W_per_m2K * area_m2 / flow_W_per_K) / area_m2;
}

}  // namespace spindle_twin::correction
