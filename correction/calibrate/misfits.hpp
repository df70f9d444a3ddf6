#pragma once

#include <string>
#include <vector>

#include "correction/calibrate/calibrate.hpp"

namespace spindle_twin::correction {

/// What does not keep `limits`, each in words with channel and number; empty: it fits. Of `result`: fit, held_out,
/// asked.
std::vector<std::string> misfits_of(const CalibrationResult& result, const rom::Network& network,
                                    const CalibrateOptions& options, const CalibrateLimits& limits);

/// Of probes that do not read what they should, what they seem to read: with β the slope of the readings over what the
/// model foresaw before the fit, least squares, where the two move together (correlation beyond 0.8) by 1 um rms or
/// more: β near −1 the other sign, β a thousand times off another unit, any other below 1/4 or beyond 4 another scale.
std::vector<std::string> hints_of(const CalibrationResult& result, const rom::Network& network,
                                  const CalibrateOptions& options);

}  // namespace spindle_twin::correction
