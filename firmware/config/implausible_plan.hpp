#pragma once

#include <vector>

#include "firmware/config/config.hpp"
#include "rom/network.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

/// What is likely a mistake of units in what the daemon would run (rom::plausible_inputs): constants of signals, which
/// the cycle believes as they are, with file, line and field, and heats, films and contacts of the network. Signals
/// that are told are judged in the cycle instead. Allocates: not for the cycle.
std::vector<rom::InputError> implausible_plan(const Config& config, const rom::Network& network, const CyclePlan& plan);

}  // namespace spindle_twin::firmware
