#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/thermal_test.hpp"

namespace spindle_twin::correction {

/// How far the spindle may have been from start_K where a test began: the larger of what any sensor read off it in the
/// first held_s, beyond 3 deviations of a reading (noise and offset), and of what start_K is warmer than the warmest
/// or colder than the coldest of its surroundings. 0: it stood as cold as said.
double start_spread_K(const ThermalTest& test, const CalibrateOptions& options);

/// 1σ of a parameter of the start in a test with such a spread, at least that of its prior: the spread for the whole
/// spindle and each group, twice that for the steady rises (no sensor need be where the spindle is warmest).
double start_deviation_K(const ParameterModel& parameters, Eigen::Index i, double spread_K);

/// All unknowns z of some tests at once: what is of the machine (heats, contacts, films, speed exponents, bearing
/// temperature, capacities) and the lags of its sensors once; environments, unexplained heats, start, offsets of
/// sensors and zeros of probes for each test anew. The start of a test that begins warm is open, as in the estimator
/// (EstimatorCorrection).
class TestUnknowns {
 public:
  TestUnknowns(const rom::Network& network, const ParameterModel& parameters, const CalibrateOptions& options,
               const std::vector<ThermalTest>& tests);
  /// Of so many tests that begin as cold as the priors say.
  TestUnknowns(const rom::Network& network, const ParameterModel& parameters, const CalibrateOptions& options,
               std::size_t tests);

  Eigen::Index count() const { return mean_.size(); }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// Lower Cholesky factor of the prior covariance: z = mean + root u, u standard normal.
  const Eigen::MatrixXd& root() const { return root_; }
  /// Parameters of the machine: their places in θ, the same as their places in z from 0 on.
  const std::vector<Eigen::Index>& machine() const { return machine_; }

  /// θ of a test within the limits of its parameters, and the sensors' lags, not below 0.
  Eigen::VectorXd theta(const Eigen::VectorXd& z, std::size_t test) const;
  Eigen::VectorXd lag_s(const Eigen::VectorXd& z) const;
  /// Offset of a sensor or zero of a probe.
  double offset(const Eigen::VectorXd& z, std::size_t test, int channel) const { return z[offset_at(test, channel)]; }

  /// d(model + offset)/dz of each reading of a test, r x count.
  Eigen::MatrixXd rows(const TestPrediction& prediction, std::size_t test) const;
  /// The same of a row on θ without a channel.
  Eigen::VectorXd row(const Eigen::VectorXd& theta_row, std::size_t test) const;

 private:
  /// `spreads_K` as of start_spread_K, one per test.
  TestUnknowns(const rom::Network& network, const ParameterModel& parameters, const CalibrateOptions& options,
               const std::vector<double>& spreads_K);
  Eigen::Index offset_at(std::size_t test, int channel) const;

  std::vector<Parameter> list_;
  std::vector<Eigen::Index> machine_, of_test_;
  Eigen::Index sensors_ = 0, channels_ = 0;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd root_;
};

}  // namespace spindle_twin::correction
