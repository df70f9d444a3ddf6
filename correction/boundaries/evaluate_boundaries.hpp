#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::correction {

/// All factors 1.
rom::CorrectionFactors no_correction(const rom::Boundaries& boundaries);

/// Sizes `values` for `boundaries`; the only call here that allocates.
rom::BoundaryValues make_boundary_values(const rom::Boundaries& boundaries);

/// gⱼ = factorⱼ · nominalⱼ · lawⱼ(speed, load), q_i likewise; environments copied. [W/m²K, W, K]
/// A measured heat is factor times the watts of the state; where it has none, that of the law.
/// A physical law is taken at its nominal temperatures and so held; whoever integrates a network lets it follow its own
/// (rom::LawDrive, which is filled in and says so).
/// For the segments of a coolant circuit g becomes the effective G/A of the channel law (rom::CoolantCircuit), 0
/// without flow; the circuits' ṁ c are filled in. Node heats and capacity factors are copied; where `factors` has none
/// they stay as long as they were and become 0 and 1. Cycle-safe: no allocation when `values` came from
/// make_boundary_values, after the first call with node heats or capacity factors.
void evaluate_boundaries(const rom::Boundaries& boundaries, const rom::OperatingState& state,
                         const rom::CorrectionFactors& factors, rom::BoundaryValues& values);

}  // namespace spindle_twin::correction
