#pragma once

#include <cmath>

namespace spindle_twin::correction {

inline constexpr double most_surprise = 9.0;         ///< three σ: beyond, one update would decide alone
inline constexpr double evidence_memory_s = 3600.0;  ///< a drift of 0.2 K/h needs about that long to show (measured)

/// What one innovation adds to the evidence against a filter: (innovation / σ)², at most `most_surprise`. A comparison
/// with what is no number gives the bound: no evidence is drawn from it. May run in the cycle.
inline double surprise(double innovation, double variance) {
  return std::fmin(innovation * innovation / variance, most_surprise);
}

}  // namespace spindle_twin::correction
