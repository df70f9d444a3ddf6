#include "fem_offline/mesh/error_left.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::fem_offline {

double error_left(double first_change, double second_change, int degree) {
  constexpr double least_order = 0.7, safe_order = 1.0;
  const double ratio = second_change != 0.0 ? first_change / second_change : 0.0;
  const double order = ratio > 1.0 ? std::clamp(std::log2(ratio), least_order, 2.0 * degree) : safe_order;
  // The changes to come are a geometric series.
  const double sum = first_change + second_change / (1.0 - std::exp2(-order));
  const bool turns_back = ratio < 0.0;
  return turns_back && std::abs(sum) < std::abs(first_change) ? first_change : sum;
}

}  // namespace spindle_twin::fem_offline
