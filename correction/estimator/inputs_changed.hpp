#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::correction {

/// Whether a period in which the sensitivities hold their inputs ends because these are others now: speed or a flow by
/// more than 0.2 %, load by 0.01, current or power by 5 % (heat follows the square of a current; drives tell noisy
/// ones), or told and no longer. Environments run on within a period. Cycle-safe.
bool inputs_changed(const rom::OperatingState& now, const rom::OperatingState& held);

}  // namespace spindle_twin::correction
