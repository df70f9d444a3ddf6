#include "correction/calibrate/calibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/calibrate/in_words.hpp"
#include "correction/calibrate/misfits.hpp"
#include "correction/calibrate/promise.hpp"
#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double seen_share = 0.75;  // of each test; the rest is held out

/// Deviations within which a value that lies beyond its limits is no other than the limit itself.
constexpr double sure_of = 3.0;

/// Parameters beyond what a network is made for go back to there; those that are surely beyond are named.
std::vector<std::string> bound_parameters(const std::vector<Parameter>& machine, Calibration& calibration) {
  std::vector<std::string> misfits;
  for (std::size_t i = 0; i < machine.size(); ++i) {
    double& value = calibration.mean[static_cast<Eigen::Index>(i)];
    const double bounded = std::clamp(value, machine[i].minimum, machine[i].maximum);
    const double deviation = calibration.root.row(static_cast<Eigen::Index>(i)).norm();
    if (std::abs(value - bounded) > sure_of * deviation) {
      misfits.push_back(in_words("%s: would have to be %.3g, sure to %.2g; believed is %.3g to %.3g",
                                 machine[i].name.c_str(), value, deviation, machine[i].minimum, machine[i].maximum));
    }
    value = bounded;
  }
  return misfits;
}

bool is_nothing_determined(const Calibration& calibration) {
  for (Eigen::Index i = 0; i < calibration.mean.size(); ++i) {
    if (is_determined(calibration, i)) return false;
  }
  return true;
}

/// What the fit says of the machine, and of which tests.
void note_machine(const FitTask& task, const TestUnknowns& unknowns, CalibrationResult& result) {
  Calibration& calibration = result.calibration;
  const auto count = static_cast<Eigen::Index>(unknowns.machine().size());
  calibration.spindle = task.network.spindle;
  calibration.mean = result.fit.z.head(count);
  calibration.root = Eigen::LLT<Eigen::MatrixXd>(result.fit.covariance.topLeftCorner(count, count)).matrixL();
  calibration.prior_mean = unknowns.mean().head(count);
  calibration.prior_deviation = calibration.nominal = Eigen::VectorXd(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Parameter& parameter =
        task.predictor.parameters().list()[static_cast<std::size_t>(unknowns.machine()[static_cast<std::size_t>(i)])];
    result.machine.push_back(parameter);
    calibration.names.push_back(parameter.name);
    calibration.prior_deviation[i] = parameter.deviation;
    calibration.nominal[i] = parameter.nominal;
  }
  for (const ThermalTest& test : task.tests) {
    calibration.tested_s += test.length_s();
    calibration.logs.push_back(test.name);
  }
}

void judge(const FitTask& task, const CalibrateLimits& limits, CalibrationResult& result) {
  Calibration& calibration = result.calibration;
  result.misfits = misfits_of(result, task.network, task.options, limits);
  for (std::string& misfit : bound_parameters(result.machine, calibration)) result.misfits.push_back(std::move(misfit));
  if (calibration.tested_s < limits.shortest_s) {
    result.misfits.push_back(in_words("%.0f min of test are too short to be judged, at least %.0f",
                                      calibration.tested_s / rom::seconds_per_minute,
                                      limits.shortest_s / rom::seconds_per_minute));
  }
  if (is_nothing_determined(calibration)) {
    result.misfits.emplace_back("no parameter is determined: these readings tell nothing of the machine");
  }
  calibration.accepted = result.misfits.empty();
  if (!calibration.accepted) result.hints = hints_of(result, task.network, task.options);
  const NosePromise promise = promise_of(task.network, task.predictor, task.options, calibration);
  calibration.promised_m = promise.tested_m;
  result.untested_m = promise.untested_m;
}

}  // namespace

bool is_determined(const Calibration& calibration, Eigen::Index i) {
  constexpr double left_of_prior = 0.9;
  return calibration.root.row(i).norm() <= left_of_prior * calibration.prior_deviation[i];
}

CalibrationResult calibrate(const rom::Network& network, const CalibrateOptions& options,
                            const std::vector<ThermalTest>& tests, const CalibrateLimits& limits,
                            const std::function<void(const char*, int)>& progress) {
  const TestPredictor predictor(network, options);
  const TestUnknowns unknowns(network, predictor.parameters(), options, tests);
  const auto say = [&](const char* what) {
    return [&progress, what](int count) {
      if (progress) progress(what, count);
    };
  };
  std::vector<ThermalTest> seen;
  seen.reserve(tests.size());
  for (const ThermalTest& test : tests) seen.push_back(first_part(test, seen_share));
  const TestFit first = fit_tests({network, predictor, options, seen}, nullptr, say("fit of the first three quarters"));
  CalibrationResult result;
  const FitTask task{network, predictor, options, tests};
  result.held_out = hold_out(task, first, seen_share);
  SeveralStarts several = fit_from_several(task, first.z, say("fit of all readings"));
  result.fit = std::move(several.fit);
  result.starts = std::move(several.starts);
  result.fit.evaluations += first.evaluations;
  result.asked = heats_asked_for(task, result.fit);
  for (const ThermalTest& test : tests) {
    result.before.push_back(
        predictor.predict(test, unknowns.theta(unknowns.mean(), 0), unknowns.lag_s(unknowns.mean())));
  }
  note_machine(task, unknowns, result);
  judge(task, limits, result);
  return result;
}

}  // namespace spindle_twin::correction
