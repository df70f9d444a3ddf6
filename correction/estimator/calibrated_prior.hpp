#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace spindle_twin::correction {

/// What is known of n unknowns of one machine, by their names: mean and covariance (n x n, symmetric, positive
/// definite), in their units. The name is Parameter::name, "lag SENSOR" or "offset SENSOR".
struct KnownParameters {
  std::vector<std::string> names;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  /// What the factor of each ln factor multiplies, in W, W/K or J/K; 1 of all others. Empty: nobody said. A network
  /// with other nominal values takes the product over, so the ln factor moves by ln(nominal / its own).
  Eigen::VectorXd nominal = {};
};

/// What is known of some parameters before a filter begins, instead of the priors of an unknown machine.
struct CalibratedPrior : KnownParameters {
  std::string origin;  ///< tells one from another: what was learnt from one prior does not go on from another
  double made_unix_s = 0.0;
  double promised_m = 0.0;  ///< 1σ of the first deformation output, as of calibrate/promise
};

}  // namespace spindle_twin::correction
