#pragma once

#include <functional>
#include <vector>

#include "correction/calibrate/fit.hpp"

namespace spindle_twin::correction {

/// Where one start of a fit has led to.
struct StartedFit {
  double cost = 0.0;   ///< above that of the best
  double apart = 0.0;  ///< farthest parameter of the machine from the best, in the best fit's deviations
  int evaluations = 0;
  bool is_other = false;  ///< another minimum about as good as the best: apart > 1, cost < 3
};

/// The best of several fits.
struct SeveralStarts {
  TestFit fit;  ///< its covariance covers the other minima: each is within 2 deviations
  std::vector<StartedFit> starts;
};

/// A fit from `first` on (fit_tests), then from CalibrateOptions::starts - 1 draws of the machine's prior, as pairs on
/// both sides of its mean, within the parameters' limits: what the data determine is found in a few steps, what they
/// leave open begins where it was drawn. Each goes once through the fit with the first one's W; one that ends elsewhere
/// (more than half a deviation away) is fitted in full. The lowest cost wins. A minimum beside it that is more than a
/// deviation away and whose cost is less than 3 higher (a twentieth of its density) widens the covariance by a quarter
/// of the square of what lies between. Starts run in threads; the result does not depend on how many. Throws as
/// fit_tests does for `first`. `progress`: model runs so far.
SeveralStarts fit_from_several(const FitTask& task, const Eigen::VectorXd& first,
                               const std::function<void(int)>& progress);

}  // namespace spindle_twin::correction
