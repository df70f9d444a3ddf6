#pragma once

#include <string>

#include "firmware/cycle/plan.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// In words, what the configured sensors will tell in an hour at the described operating state from a cold start, with
/// the configured priors (correction/identify): standard deviation of the first deformation without and with them, and
/// which parameters stay as described. Empty where no estimator corrects. Integrates an hour: not for the cycle.
std::string expect_of_sensors(const rom::Network& network, const CyclePlan& plan);

}  // namespace spindle_twin::firmware
