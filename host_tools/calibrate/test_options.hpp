#pragma once

#include <string>

#include "correction/calibrate/thermal_test.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What a test of a machine that was never tested is fitted with: all key points as sensors, noise, offsets, lags and
/// priors as the daemon's configuration has them, else its defaults; laws of speed and temperature wide open (0.2, 0.01
/// /K), heats that no source explains shut. `config`: a path, empty for none. Throws rom::InputError as
/// firmware::read_config does, and for a configuration without the estimator.
correction::CalibrateOptions test_options(const rom::Network& network, const std::string& config);

}  // namespace spindle_twin::host_tools
