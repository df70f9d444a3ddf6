#pragma once

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/unknowns.hpp"
#include "correction/calibration/calibration.hpp"

namespace spindle_twin::correction {

/// What is known of the nose, the first deformation output, after four hours from the reference temperature at the
/// described operating state, without any sensor: the same question whatever the test was. 0 without an output.
struct NosePromise {
  double tested_m = 0.0;    ///< 1σ with the calibration, drift since the test included
  double untested_m = 0.0;  ///< 1σ with the priors of an unknown machine
};

/// With s = d(nose)/dθ then, at the calibration's means:   σ² = sᵀ P s,   P the covariance of what is of the machine.
/// One run of the model. Throws rom::InputError as TestPredictor::predict. Not for the cycle.
NosePromise promise_of(const rom::Network& network, const TestPredictor& predictor, const CalibrateOptions& options,
                       const Calibration& calibration);

}  // namespace spindle_twin::correction
