#pragma once

#include <functional>
#include <string>
#include <vector>

#include "correction/calibrate/asked_heat.hpp"
#include "correction/calibrate/fit.hpp"
#include "correction/calibrate/hold_out.hpp"
#include "correction/calibrate/several_starts.hpp"
#include "correction/calibration/calibration.hpp"

namespace spindle_twin::correction {

/// What a calibration must keep to be written without a person's word.
struct CalibrateLimits {
  double held_out_m = 2e-6;       ///< rms of a probe in the part of a test that the fit has not seen
  double held_out_mean = 3.0;     ///< deviations of the mean of any channel there
  double chi_square = 1.15;       ///< per reading
  double asked_before = 3.0;      ///< deviations of a heat that first parts ask for and no source explains, and
  double asked_after = 1.0;       ///< of the same heat in what is held out, which by chance is so once in six
  double times_expected = 3.0;    ///< rms of any channel there, of what the fit itself allows for
  double asked_heat = 4.0;        ///< deviations of a heat that all readings ask for and those held out do not deny
  double asked_heat_alone = 8.0;  ///< the same of one that they do not confirm
  double asked_share = 0.01;      ///< of all nominal heats: no smaller heat counts, whatever it is sure to
  double shortest_s = 1200.0;     ///< all tests together: the last quarter of less has hardly a reading to judge by
};

struct CalibrationResult {
  Calibration calibration;             ///< without file names, hash and time
  TestFit fit;                         ///< of all readings
  HoldOut held_out;                    ///< the last part, predicted by a fit of what is before it
  std::vector<StartedFit> starts;      ///< of the fit of all readings
  std::vector<AskedHeat> asked;        ///< the surest first
  std::vector<std::string> misfits;    ///< in words, each with channel and number; empty: it fits
  std::vector<std::string> hints;      ///< of one that does not fit, what a probe seems to read (hints_of)
  double untested_m = 0.0;             ///< what calibration.promised_m would be without any test (NosePromise)
  std::vector<Parameter> machine;      ///< the calibrated parameters, as the priors have them
  std::vector<TestPrediction> before;  ///< of each test with the priors' means
};

/// A parameter's deviation is at most 0.9 of that of its prior.
bool is_determined(const Calibration& calibration, Eigen::Index i);

/// Steps: fit the first part of each test; predict the last part, compare, and try on it the heat that the first asks
/// for; fit all; ask for heats that no source explains; judge. A parameter beyond its limits (Parameter) is set to
/// them, and is a misfit where it is further off than 3 of its deviations; so is a test that determines none. Throws
/// rom::InputError as fit_tests does. Not for the cycle. `progress`: what is being done, and how often the model has
/// run.
CalibrationResult calibrate(const rom::Network& network, const CalibrateOptions& options,
                            const std::vector<ThermalTest>& tests, const CalibrateLimits& limits,
                            const std::function<void(const char*, int)>& progress = {});

}  // namespace spindle_twin::correction
