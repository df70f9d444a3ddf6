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
  double held_out_m = 2e-6;     ///< rms of a probe in the part of a test that the fit has not seen
  double held_out_mean = 3.0;   ///< deviations of the mean of any channel there
  double chi_square = 1.15;     ///< per reading
  double asked_before = 3.0;    ///< deviations of a heat that first parts ask for and no source explains, and
  double asked_after = 1.0;     ///< of the same heat in what is held out, which by chance is so once in six
  double times_expected = 3.0;  ///< rms of any channel there, of what the fit itself allows for
  double asked_heat = 4.0;      ///< deviations of a heat that readings ask for and no source explains
  double shortest_s = 1200.0;   ///< all tests together: the last quarter of less has hardly a reading to judge by
};

struct CalibrationResult {
  Calibration calibration;             ///< without file names, hash and time
  TestFit fit;                         ///< of all readings
  HoldOut held_out;                    ///< the last part, predicted by a fit of what is before it
  std::vector<StartedFit> starts;      ///< of the fit of all readings
  std::vector<AskedHeat> asked;        ///< the surest first
  std::vector<std::string> misfits;    ///< in words, each with channel and number; empty: it fits
  std::vector<Parameter> machine;      ///< the calibrated parameters, as the priors have them
  std::vector<TestPrediction> before;  ///< of each test with the priors' means
};

/// Steps: fit the first part of each test; predict the last part, compare, and try on it the heat that the first asks
/// for; fit all; ask for heats that no source explains; judge. A parameter beyond its limits (Parameter) is set to
/// them, and is a misfit. Throws rom::InputError as fit_tests does. Not for the cycle. `progress`: what is being done,
/// and how often the model has run.
CalibrationResult calibrate(const rom::Network& network, const CalibrateOptions& options,
                            const std::vector<ThermalTest>& tests, const CalibrateLimits& limits,
                            const std::function<void(const char*, int)>& progress = {});

}  // namespace spindle_twin::correction
