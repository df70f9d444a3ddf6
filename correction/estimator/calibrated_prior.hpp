#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace spindle_twin::correction {

/// What is known of some parameters before a filter begins, instead of the priors of an unknown machine: mean and
/// covariance of n parameters by their names (Parameter::name), in their units. The covariance (n x n) is symmetric and
/// positive definite.
struct CalibratedPrior {
  std::string origin;  ///< tells one from another: what was learnt from one prior does not go on from another
  double made_unix_s = 0.0;
  double promised_m = 0.0;  ///< 1σ of the first deformation output at the end of the test
  std::vector<std::string> names;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

}  // namespace spindle_twin::correction
