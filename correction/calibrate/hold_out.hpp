#pragma once

#include <optional>
#include <vector>

#include "correction/calibrate/asked_heat.hpp"
#include "correction/calibrate/fit.hpp"

namespace spindle_twin::correction {

/// A heat that no source explains: what the first parts of all tests ask for, and what the last ones say of it alone.
struct HeldOutHeat {
  AskedHeat before, after;
};

struct HoldOut {
  std::vector<ChannelFit> channels;  ///< what is left of the readings held out, with their means
  std::optional<HeldOutHeat> heat;   ///< the surest of the first parts; none where the network has no groups
};

/// The readings h of each test after `before_share` of its length, as `seen`, a fit of those before, s, foresees them.
/// Readings r of model and W as in fit_tests, P and left of `seen`, a = d(model)/dw of a heat (asked_heat):
///   B = W_hs W_ss⁻¹,   Z = J_h − B J_s,   r = left_h − B left_s,   C = W_hh − B W_sh + Z P Zᵀ
///   mean of a channel, e = 1/n at its n readings:   eᵀ r,   σ² = eᵀ C e + error² + (share rise)²
///   heat:   c = a_h − B a_s − Z P Σ J_sᵀ W_ss⁻¹ a_s,   w = cᵀ C⁻¹ r / cᵀ C⁻¹ c,   σ² = 1 / cᵀ C⁻¹ c
/// B carries on what joints and a probe have wandered by before. Errors of a sensor's place last: they do not fall with
/// n. The rms of a channel cannot judge its mean: its readings are wrong together, and so 2 rms are 2σ and no more. A
/// fit of the first parts has bent towards an untold heat, so c is what is left of it in the last ones: r tells of it
/// what the first parts do not. Throws as judge_tests. Not for the cycle.
HoldOut hold_out(const FitTask& task, const TestFit& seen, double before_share);

}  // namespace spindle_twin::correction
