#pragma once

#include "correction/estimator/estimator_options.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// The options with the key points' sensors filled in where there are none. Throws rom::InputError naming the option
/// and what is allowed.
EstimatorOptions checked(const rom::Network& network, EstimatorOptions options);

}  // namespace spindle_twin::correction
