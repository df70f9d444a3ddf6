#include "correction/calibrate/promise.hpp"

#include <cmath>
#include <limits>

namespace spindle_twin::correction {
namespace {

constexpr double lasts_s = 4.0 * 3600.0;

/// Four hours without a reading.
ThermalTest unread(const rom::Network& network, const CalibrateOptions& options) {
  constexpr double not_read = std::numeric_limits<double>::quiet_NaN();
  ThermalTest test;
  test.name = "four hours at the described operating state";
  test.time_s = {0.0, lasts_s};
  test.operating.assign(test.time_s.size(), network.boundaries.operating);
  const auto rows = static_cast<Eigen::Index>(test.time_s.size());
  test.measured_K = Eigen::MatrixXd::Constant(rows, static_cast<Eigen::Index>(options.sensors.size()), not_read);
  test.deformation_m =
      Eigen::MatrixXd::Constant(rows, static_cast<Eigen::Index>(network.deformations.size()), not_read);
  test.start_K = network.boundaries.reference_temperature_K;
  return test;
}

double deviation_along(const Eigen::VectorXd& row, const Eigen::MatrixXd& covariance) {
  return std::sqrt(std::max(0.0, row.dot(covariance * row)));
}

}  // namespace

NosePromise promise_of(const rom::Network& network, const TestPredictor& predictor, const CalibrateOptions& options,
                       const Calibration& calibration) {
  if (network.deformations.empty()) return {};
  const TestUnknowns unknowns(network, predictor.parameters(), options, 1);
  const Eigen::Index count = calibration.mean.size();
  Eigen::VectorXd z = unknowns.mean();
  z.head(count) = calibration.mean;
  const TestPrediction there = predictor.predict(unread(network, options), unknowns.theta(z, 0), unknowns.lag_s(z));
  const Eigen::VectorXd row = unknowns.row(there.last_output, 0).head(count);
  const Eigen::MatrixXd unknown_root = unknowns.root().topLeftCorner(count, count);
  return {deviation_along(row, prior_of(calibration, {})->covariance),
          deviation_along(row, unknown_root * unknown_root.transpose())};
}

}  // namespace spindle_twin::correction
