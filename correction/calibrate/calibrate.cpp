#include "correction/calibrate/calibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double seen_share = 0.75;  // of each test; the rest is held out

template <class... Values>
std::string in_words(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// Deviations within which a value that lies beyond its limits is no other than the limit itself.
constexpr double sure_of = 2.0;

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

std::vector<std::string> find_misfits(const CalibrationResult& result, const CalibrateOptions& options,
                                      const CalibrateLimits& limits) {
  std::vector<std::string> misfits;
  if (result.fit.chi_square_per_reading > limits.chi_square) {
    misfits.push_back(in_words("all readings together: chi-square %.2f per reading, at most %.2f",
                               result.fit.chi_square_per_reading, limits.chi_square));
  }
  for (const ChannelFit& channel : result.held_out.channels) {
    const bool is_probe = channel.channel >= static_cast<int>(options.sensors.size());
    const double scale = is_probe ? rom::um_per_m : 1.0;
    const char* unit = is_probe ? "um" : "K";
    // Of a probe that was not read before nobody knows the zero: what its readings are off by themselves says nothing.
    const bool zero_is_known = channel.expected_rms < limits.times_expected * limits.held_out_m;
    if (is_probe && zero_is_known && channel.rms > limits.held_out_m) {
      misfits.push_back(in_words("%s, held out: %.2f um rms, at most %.2f um", channel.name.c_str(),
                                 rom::um_per_m * channel.rms, rom::um_per_m * limits.held_out_m));
    }
    if (std::abs(channel.held_out->off) > limits.held_out_mean * channel.held_out->deviation) {
      misfits.push_back(in_words("%s, held out: on average %.3f %s off where the fit is sure to %.3f %s",
                                 channel.name.c_str(), scale * channel.held_out->off, unit,
                                 scale * channel.held_out->deviation, unit));
    }
    if (channel.rms > limits.times_expected * channel.expected_rms) {
      misfits.push_back(in_words("%s, held out: %.3f %s rms where the fit allows for %.3f %s", channel.name.c_str(),
                                 scale * channel.rms, unit, scale * channel.expected_rms, unit));
    }
  }
  if (result.held_out.heat) {
    const auto& [before, after] = *result.held_out.heat;
    const bool agree = (before.heat_W > 0.0) == (after.heat_W > 0.0);
    if (agree && before.deviations() > limits.asked_before && after.deviations() > limits.asked_after) {
      misfits.push_back(
          in_words("held out: before the last quarter readings ask for %.0f W +- %.0f W in %s that no source explains, "
                   "in it for %.0f W +- %.0f W",
                   before.heat_W, before.deviation_W, before.group.c_str(), after.heat_W, after.deviation_W));
    }
  }
  for (const AskedHeat& heat : result.asked) {
    if (heat.deviations() <= limits.asked_heat) break;  // the surest stand first
    misfits.push_back(in_words("the readings ask for %.0f W +- %.0f W in %s that no source explains", heat.heat_W,
                               heat.deviation_W, heat.group.c_str()));
  }
  return misfits;
}

/// σ of the first deformation output at the end of the longest test, of what is of the machine.
double promised_m(const TestFit& fit, const TestUnknowns& unknowns, const std::vector<ThermalTest>& tests,
                  const CalibratedPrior& prior) {
  std::size_t longest = 0;
  for (std::size_t test = 1; test < tests.size(); ++test) {
    if (tests[test].length_s() > tests[longest].length_s()) longest = test;
  }
  const Eigen::VectorXd& output = fit.readings[longest].last_output;
  if (output.size() == 0) return 0.0;
  const Eigen::VectorXd row = unknowns.row(output, longest).head(prior.mean.size());
  return std::sqrt(std::max(0.0, row.dot(prior.covariance * row)));
}

}  // namespace

CalibrationResult calibrate(const rom::Network& network, const CalibrateOptions& options,
                            const std::vector<ThermalTest>& tests, const CalibrateLimits& limits,
                            const std::function<void(const char*, int)>& progress) {
  const TestPredictor predictor(network, options);
  const TestUnknowns unknowns(network, predictor.parameters(), options, tests.size());
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

  Calibration& calibration = result.calibration;
  const auto count = static_cast<Eigen::Index>(unknowns.machine().size());
  calibration.spindle = network.spindle;
  calibration.mean = result.fit.z.head(count);
  calibration.root = Eigen::LLT<Eigen::MatrixXd>(result.fit.covariance.topLeftCorner(count, count)).matrixL();
  calibration.prior_mean = unknowns.mean().head(count);
  calibration.prior_deviation = calibration.nominal = Eigen::VectorXd(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Parameter& parameter =
        predictor.parameters().list()[static_cast<std::size_t>(unknowns.machine()[static_cast<std::size_t>(i)])];
    result.machine.push_back(parameter);
    calibration.names.push_back(parameter.name);
    calibration.prior_deviation[i] = parameter.deviation;
    calibration.nominal[i] = parameter.nominal;
  }
  for (const ThermalTest& test : tests) {
    calibration.tested_s += test.length_s();
    calibration.logs.push_back(test.name);
  }
  result.misfits = find_misfits(result, options, limits);
  for (std::string& misfit : bound_parameters(result.machine, calibration)) result.misfits.push_back(std::move(misfit));
  if (calibration.tested_s < limits.shortest_s) {
    result.misfits.push_back(in_words("%.0f min of test are too short to be judged, at least %.0f",
                                      calibration.tested_s / rom::seconds_per_minute,
                                      limits.shortest_s / rom::seconds_per_minute));
  }
  calibration.accepted = result.misfits.empty();
  calibration.promised_m = promised_m(result.fit, unknowns, tests, *prior_of(calibration, {}));
  return result;
}

}  // namespace spindle_twin::correction
