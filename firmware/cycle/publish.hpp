#pragma once

#include "firmware/cycle/correct.hpp"

// All but first_snapshot() run in the cycle: no heap, no lock, no exception.
namespace spindle_twin::firmware {

/// Copies a network's predictions into the snapshot; the nose minus snapshot.tare_m. A published deformation moves
/// towards the prediction by most_m at most, so that a correction is no step for the machine, and stays within plus and
/// minus its limit_m, the nose also minus the tare.
void publish_corrected(const Model& model, double most_m, const std::array<double, slots::deformations>& limit_m,
                       Snapshot& snapshot);
void publish_uncorrected(const Model& model, Snapshot& snapshot);

/// Readings, quality and signals of this cycle.
void publish_inputs(const SensedInputs& sensed, const Judgement& judgement, Snapshot& snapshot);

/// Nose minus tare once more, where the tare has moved since.
void publish_nose(double limit_m, Snapshot& snapshot);

/// Takes the present prediction of the nose, within plus and minus limit_m, as its zero: what is published is zero at
/// once, whatever the slew limit. False where there is no nose.
bool tare(double limit_m, Snapshot& snapshot);

/// Factors in use and what the law says.
void publish_correction(const Corrector& corrector, const rom::CorrectionFactors& factors, Snapshot& snapshot);

/// Standard deviations and what became of each reading; of a deformation that is on its way to the prediction the way
/// that is left counts too. After publish_corrected().
void publish_estimate(const Corrector& corrector, Snapshot& snapshot);

/// What the compensation will be, if nothing else changes. After Compensation::step().
void publish_forecast(const Forecast& forecast, const CompensationPlan& plan, Snapshot& snapshot);

/// A snapshot with the network's counts, all values NaN. Allocates; not for the cycle.
Snapshot first_snapshot(const rom::Network& network);

}  // namespace spindle_twin::firmware
