#pragma once

#include "fem_offline/model/affine_model.hpp"
#include "rom/network.hpp"

namespace spindle_twin::bench {

/// The two spindles of the twin campaign (A, seeds 1026 and 2002) in which a poor ball contact and a large heat of the
/// front bearing hide each other, so that a filter without a test is off by more than it says. Each gets the test with
/// a probe and a day of 2 h; prints hidden parameters and nose against 2σ. How many of these limits are missed: nose
/// inside for 0.9 of the day, with six sensors without a test too; front bearing's heat and ball contacts inside, 0.9
/// of all hidden parameters.
int check_hidden_pairs(const rom::Network& network, const fem_offline::AffineModel& truth_model, int threads);

}  // namespace spindle_twin::bench
