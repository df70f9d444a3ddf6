#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/thermal_test.hpp"
#include "correction/calibrate/unknowns.hpp"

namespace spindle_twin::correction {

/// How far readings that a fit has not seen lie from what it foresees, on average. K or m.
struct HeldOutMean {
  double off = 0.0;        ///< positive: the readings are higher
  double deviation = 0.0;  ///< 1σ
};

/// What is left of the readings of one channel in one test.
struct ChannelFit {
  std::string name;
  std::size_t test = 0;
  int channel = 0;
  std::size_t readings = 0;
  double rms = 0.0;                     ///< of reading − model − offset; K or m
  double expected_rms = 0.0;            ///< what residual covariance and posterior allow for
  double lag_1 = 0.0;                   ///< autocorrelation of neighbouring residuals
  std::size_t outliers = 0;             ///< readings that count less
  std::optional<HeldOutMean> held_out;  ///< of readings that are held out (hold_out)
};

/// Tests and what they are fitted with; all of it must outlive this.
struct FitTask {
  const rom::Network& network;
  const TestPredictor& predictor;
  const CalibrateOptions& options;
  const std::vector<ThermalTest>& tests;
};

/// z of the tests with all that the readings say.
struct TestFit {
  Eigen::VectorXd z;
  Eigen::MatrixXd covariance;             ///< of z
  std::vector<TestPrediction> readings;   ///< of each test at z
  std::vector<Eigen::VectorXd> left;      ///< residual − offset of each reading
  std::vector<Eigen::MatrixXd> expected;  ///< covariance of what is left: W + h P hᵀ
  std::vector<ChannelFit> channels;
  double chi_square_per_reading = 0.0;   ///< of the whitened residuals; 1 of a model that is as good as assumed
  std::vector<Eigen::MatrixXd> weights;  ///< W of each test at z, outliers wider
  double cost = 0.0;  ///< -ln of the posterior at z but for a constant: ½ (left W⁻¹ left + ln det W + |u|²)
  int evaluations = 0;
};

/// Nonlinear least squares of all tests at once with the priors, by Levenberg and Marquardt in MINPACK's form (Moré,
/// 1978; Eigen's unsupported module):
///   min ½ |L⁻¹ (reading − model(z) − offset)|² + ½ |u|²,   z = mean + root u,   W = L Lᵀ (residual_covariance)
/// W is of the sensitivities at the start, then twice anew at the solution; there a reading that is q > 3 of its
/// deviations off gets 1 + q (q/3 - 1) times its variance, so that it pulls the less the further it is off. The
/// posterior is that of the last linearisation.
/// Several tests run in threads of their own; the result does not depend on how many. Throws rom::InputError where the
/// model cannot be integrated, and for a test without a reading. `progress`: after each evaluation of all tests.
TestFit fit_tests(const FitTask& task, const Eigen::VectorXd* start, const std::function<void(int)>& progress);

/// One pass of it from `start` on with W as it is in `weights`: where this start leads to, at a third of the cost.
TestFit fit_tests_once(const FitTask& task, const Eigen::VectorXd& start, const std::vector<Eigen::MatrixXd>& weights);

/// The tests predicted with z: what is left, and what covariance of z and W allow for. For data that z was not made of.
TestFit judge_tests(const FitTask& task, const Eigen::VectorXd& z, const Eigen::MatrixXd& covariance);

/// What is left of each channel's readings from this share of each test's time on.
std::vector<ChannelFit> channels_from(const FitTask& task, const TestFit& fit, double share);

/// The first `share` of a test, by time.
ThermalTest first_part(const ThermalTest& test, double share);

}  // namespace spindle_twin::correction
