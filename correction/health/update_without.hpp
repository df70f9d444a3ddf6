#pragma once

#include "correction/estimator/estimator_correction.hpp"
#include "correction/health/leave_one_out.hpp"

namespace spindle_twin::correction {

/// The estimator's last update taken into another filter over its unknowns z, without one sensor (-1: with all): with ν
/// the innovations of that filter, one sensor after the other, and V their variances, those beyond the estimator's gate
/// are left out. Gives J = Σ min(ν²/V, 9). `row` is a place to work in, as long as z. The filter has passed the time
/// already. May run in the cycle: one rank-one update per sensor.
double update_without(const EstimatorCorrection& estimator, Eigen::Index sensor, SquareRootFilter& filter,
                      Eigen::VectorXd& row);

/// What such a filter says of the sensor, before the update; the evidence stays. May run in the cycle.
void note_misfit(const EstimatorCorrection& estimator, Eigen::Index sensor, SquareRootFilter& filter,
                 Eigen::VectorXd& row, Misfit& misfit);

/// J of the estimator's own last update. May run in the cycle.
double surprise_of(const EstimatorCorrection& estimator);

}  // namespace spindle_twin::correction
