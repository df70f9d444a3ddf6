#include "correction/estimator/reduced_chi_square.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::correction {
namespace {

struct Counted {
  double chi_square = 0.0;
  double determined = 0.0;  // ν
};

Counted count(const ParameterModel& parameters, const SquareRootFilter& filter) {
  Counted counted;
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    if (!bends_the_state(parameter.kind) || !(parameter.uncalibrated_deviation > 0.0)) continue;
    const double off = (filter.mean()[i] - parameter.uncalibrated_mean) / parameter.uncalibrated_deviation;
    const double left = filter.deviation(i) / parameter.uncalibrated_deviation;
    counted.chi_square += off * off;
    counted.determined += std::max(0.0, 1.0 - left * left);
  }
  return counted;
}

}  // namespace

void ReducedChiSquare::note(const ParameterModel& parameters, const SquareRootFilter& filter, double of_readings) {
  const Counted counted = count(parameters, filter);
  determined_ = std::max(determined_, counted.determined);
  const double of_parameters = determined_ < 1.0 ? 1.0 : counted.chi_square / determined_;
  scale_factor_ = std::sqrt(std::max(1.0, of_parameters) * std::sqrt(std::max(1.0, of_readings)));
}

bool is_unlikely_machine(const ParameterModel& parameters, const SquareRootFilter& filter) {
  constexpr double one_in_a_thousand = 3.0902;  // quantile of the standard normal distribution
  const Counted counted = count(parameters, filter);
  const double degrees = std::max(1.0, counted.determined), share = 2.0 / (9.0 * degrees);
  return counted.chi_square > degrees * std::pow(1.0 - share + one_in_a_thousand * std::sqrt(share), 3.0);
}

}  // namespace spindle_twin::correction
