#pragma once

#include <vector>

#include "correction/calibrate/fit.hpp"

namespace spindle_twin::correction {

/// The readings of each test after `before_share` of its length, as `seen`, a fit of those before, foresees them: what
/// is left of each channel (ChannelFit), and its mean with that mean's deviation. Readings r of model and W as in
/// fit_tests, P and left of `seen`; s: readings before, h: those held out, e: 1/n at the n held-out readings of the
/// channel:
///   B = W_hs W_ss⁻¹,   A = J_h − B J_s
///   mean = eᵀ (left_h − B left_s),   σ² = eᵀ (W_hh − B W_sh + A P Aᵀ) e + error² + (share rise)²
/// B carries on what joints and a probe have wandered by before. Errors of a sensor's place last: they do not fall with
/// n. The rms of a channel cannot judge its mean: its readings are wrong together, and so 2 rms are 2σ and no more.
/// Throws as judge_tests. Not for the cycle.
std::vector<ChannelFit> held_out_channels(const FitTask& task, const TestFit& seen, double before_share);

}  // namespace spindle_twin::correction
