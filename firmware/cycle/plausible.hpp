#pragma once

#include "firmware/cycle/integrate.hpp"
#include "firmware/cycle/judge.hpp"

namespace spindle_twin::firmware {

/// A prediction may leave the span of all readings and surroundings by so much more than the uncorrected model does:
/// what no sensor reaches is warmer than all of them, but a correction that makes it so much warmer is none.
inline constexpr double plausible_K = 30.0;

/// By how much the corrected model leaves the span of all readings in range and of the surroundings further than the
/// uncorrected one would if all its rises above the surroundings were s times higher, s the largest ratio of a good
/// sensor's rise to the uncorrected one at its place:
///   T_uncorrected + (s − 1) max(T_uncorrected − T_s, 0),   T_s the mean of the surroundings,
///   s = max (reading − T_s)/max(T_uncorrected at its place − T_s, 5 K), from 1 to 5
/// So much hotter than described may be what no sensor reaches, too. At its worst key point or part maximum; infinite
/// where a prediction is no number, 0 where nothing is measured at all. [K] Runs in the cycle.
double outside_K(const rom::Network& network, const Judgement& judgement, const SensedInputs& sensed,
                 const Model& model, const Model& uncorrected);

}  // namespace spindle_twin::firmware
