#pragma once

namespace spindle_twin::correction {

/// What the estimator says of the model itself, by the consistency of all sensors together.
struct ModelDoubt {
  bool in_doubt = false;  ///< the model does not fit its sensors as well as it says
  double since_s = 0.0;   ///< time at which that began
};

}  // namespace spindle_twin::correction
