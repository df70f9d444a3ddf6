#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// All factors 1.
CorrectionFactors no_correction(const Boundaries& boundaries);

/// Sizes `values` for `boundaries`; the only call here that allocates.
BoundaryValues make_boundary_values(const Boundaries& boundaries);

/// gⱼ = factorⱼ · nominalⱼ · lawⱼ(speed, load), q_i likewise; environments copied. [W/m²K, W, K]
/// A measured heat is factor times the watts of the state; where it has none, that of the law.
/// A physical law is taken at its nominal temperatures and so held; whoever integrates a network lets it follow its own
/// (LawDrive, which is filled in and says so).
/// For the segments of a coolant circuit g becomes the effective G/A of the channel law (CoolantCircuit), 0
/// without flow; the circuits' ṁ c are filled in. Node heats and capacity factors are copied; where `factors` has none
/// they stay as long as they were and become 0 and 1. Cycle-safe: no allocation when `values` came from
/// make_boundary_values, after the first call with node heats or capacity factors.
void evaluate_boundaries(const Boundaries& boundaries, const OperatingState& state, const CorrectionFactors& factors,
                         BoundaryValues& values);

}  // namespace spindle_twin::rom
