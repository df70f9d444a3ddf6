#pragma once

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {

/// The estimator's last update taken into another filter over its unknowns z, without one sensor: with ν the
/// innovations of that filter, one sensor after the other, and V their variances, those beyond the estimator's gate are
/// left out. Gives J = Σ min(ν²/V, 9). `row` is a place to work in, as long as z. The filter has passed the time
/// already. May run in the cycle: one rank-one update per sensor.
double update_without(const EstimatorCorrection& estimator, Eigen::Index sensor, SquareRootFilter& filter,
                      Eigen::VectorXd& row);

/// J of the estimator's own last update. May run in the cycle.
double surprise_of(const EstimatorCorrection& estimator);

}  // namespace spindle_twin::correction
