#include "correction/estimator/factor_spread.hpp"

#include <array>
#include <cmath>

namespace spindle_twin::correction {
namespace {

/// h z with at the most three entries of h that are not 0.
struct Combination {
  std::array<int, 3> slots;  ///< -1: none
  std::array<double, 3> weights;
};

double mean_of(const Combination& h, const SquareRootFilter& filter) {
  double mean = 0.0;
  for (std::size_t c = 0; c < h.slots.size(); ++c) {
    if (h.slots[c] >= 0) mean += h.weights[c] * filter.mean()[h.slots[c]];
  }
  return mean;
}

/// √(h P hᵀ) with P = D W Wᵀ D: the length of h D W.
double deviation_of(const Combination& h, const SquareRootFilter& filter) {
  double variance = 0.0;
  for (Eigen::Index k = 0; k < filter.root().cols(); ++k) {
    double entry = 0.0;
    for (std::size_t c = 0; c < h.slots.size(); ++c) {
      const int i = h.slots[c];
      if (i >= 0) entry += h.weights[c] * filter.scale()[i] * filter.root()(i, k);
    }
    variance += entry * entry;
  }
  return std::sqrt(variance);
}

FactorSpread spread_of(const Combination& h, const FactorKnowledge& known) {
  return {mean_of(h, known.prior), deviation_of(h, known.prior), deviation_of(h, known.filter)};
}

}  // namespace

FactorSpread heat_spread(const FactorKnowledge& known, Eigen::Index source, double speed_rpm, double source_rise_K) {
  const ParameterModel& parameters = known.parameters;
  const int bearing = parameters.is_friction(source) ? parameters.bearing() : -1;
  return spread_of({{parameters.heat(source), parameters.exponent(source), bearing},
                    {1.0, parameters.log_speed(speed_rpm), -source_rise_K}},
                   known);
}

FactorSpread conductance_spread(const FactorKnowledge& known, Eigen::Index conductance) {
  return spread_of({{known.parameters.conductance(conductance), -1, -1}, {1.0, 0.0, 0.0}}, known);
}

}  // namespace spindle_twin::correction
