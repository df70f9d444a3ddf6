#include "correction/estimator/reduced_chi_square.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::correction {

void ReducedChiSquare::note(const ParameterModel& parameters, const Eigen::VectorXd& theta,
                            const SquareRootFilter& filter, double of_readings) {
  double chi_square = 0.0, determined = 0.0;
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    if (!bends_the_state(parameter.kind) || !(parameter.uncalibrated_deviation > 0.0)) continue;
    const double off = (theta[i] - parameter.uncalibrated_mean) / parameter.uncalibrated_deviation;
    const double left = filter.deviation(i) / parameter.uncalibrated_deviation;
    chi_square += off * off;
    determined += std::max(0.0, 1.0 - left * left);
  }
  determined_ = std::max(determined_, determined);
  excess_ = std::sqrt(std::max({1.0, chi_square / std::max(determined_, 1.0), of_readings}));
}

}  // namespace spindle_twin::correction
