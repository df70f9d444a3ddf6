#pragma once

#include <algorithm>
#include <cmath>

#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Page's cumulative sum (Biometrika 41, 1954), both signs, on the misfit of a channel to what all others say of it
/// (leave_one_out.hpp), z = misfit / its deviation:
///   S± ← max(0, S± ± z − slack),   alarm at S± > limit
/// On the estimator's own innovations the same sum sees next to nothing: the estimator follows a slow drift with its
/// parameters. Runs in the cycle.
struct DriftSum {
  double above = 0.0;
  double below = 0.0;

  double most() const { return std::max(above, below); }
  bool observe(double z, const HealthLimits& limits) {
    if (!std::isfinite(z)) return false;
    above = std::max(0.0, above + z - limits.drift_slack);
    below = std::max(0.0, below - z - limits.drift_slack);
    return most() > limits.drift_limit;
  }
};

}  // namespace spindle_twin::correction
