#pragma once

#include "firmware/cycle/correct.hpp"

namespace spindle_twin::firmware {

/// Copies a network's predictions into the snapshot; the nose minus snapshot.tare_m. Run in the cycle.
void publish_corrected(const Model& model, Snapshot& snapshot);
void publish_uncorrected(const Model& model, Snapshot& snapshot);

/// Readings, quality and signals of this cycle.
void publish_inputs(const SensedInputs& sensed, const Judgement& judgement, Snapshot& snapshot);

/// Factors in use and what the law says.
void publish_correction(const Corrector& corrector, const rom::CorrectionFactors& factors, Snapshot& snapshot);

/// A snapshot with the network's counts, all values NaN.
Snapshot first_snapshot(const rom::Network& network);

}  // namespace spindle_twin::firmware
