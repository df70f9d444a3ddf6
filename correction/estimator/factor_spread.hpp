#pragma once

#include <Eigen/Core>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// Of the ln of a factor, 1σ: what the prior says, and how sure an estimate is of its own.
struct FactorSpread {
  double prior_mean = 0.0;
  double prior_deviation = 0.0;
  double deviation = 0.0;
};

/// What is known of factors at one speed and at these rises of the sources (EstimatorCorrection: z = (θ, b, τ)).
struct FactorKnowledge {
  const ParameterModel& parameters;
  const SquareRootFilter& prior;
  const SquareRootFilter& filter;
};

/// ln factor = θ_heat + θ_exponent ln(|n| / n_ref) − θ_bearing rise of a heat source (the last of friction only), with
/// source_rise_K = rise of that source; by the correlations of these three. May run in the cycle; errors: none.
FactorSpread heat_spread(const FactorKnowledge& known, Eigen::Index source, double speed_rpm, double source_rise_K);

/// ln factor = θ of the contact or film. A factor that is no parameter is sure to be 1. May run in the cycle.
FactorSpread conductance_spread(const FactorKnowledge& known, Eigen::Index conductance);

}  // namespace spindle_twin::correction
