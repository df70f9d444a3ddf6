#pragma once

#include <string>
#include <vector>

#include "correction/calibrate/fit.hpp"

namespace spindle_twin::correction {

/// Heat into one thermal group, the same all through the tests, that their readings ask for beside all that was fitted.
struct AskedHeat {
  std::string group;  ///< its parts
  double heat_W = 0.0;
  double deviation_W = 0.0;  ///< 1σ

  double deviations() const;  ///< |heat| in its deviations
};

/// d(model)/dw of each reading, w a watt into one group all through the tests.
struct HeatResponses {
  std::vector<std::string> groups;       ///< their parts; empty where the network has none
  std::vector<Eigen::MatrixXd> of_test;  ///< of each test at the fit's z, readings x groups
};
/// One run of the model per test. Throws as TestPredictor::predict.
HeatResponses heat_responses(const FitTask& task, const TestFit& fit);

/// What a fit with one more unknown w, a watt into a group, would find for it, to first order at the fit (score test,
/// Rao 1948): with a = d(model)/dw of each reading, what is left r, W, and J = d(model)/du of the fit's own unknowns,
///   I = aᵀ W⁻¹ a − (aᵀ W⁻¹ J) (1 + Jᵀ W⁻¹ J)⁻¹ (Jᵀ W⁻¹ a),   w = aᵀ W⁻¹ r / I,   σ² = 1 / I
/// One run of the model per test instead of another fit; one entry per thermal group, the surest first. No entry is
/// larger than all nominal heats together: what would have to be is another error than a heat. Where the fit is bad,
/// neighbouring groups ask for the same heat. Throws as TestPredictor::predict.
std::vector<AskedHeat> heats_asked_for(const FitTask& task, const TestFit& fit);

}  // namespace spindle_twin::correction
