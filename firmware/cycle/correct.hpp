#pragma once

#include <optional>

#include "correction/paper/paper_correction.hpp"
#include "firmware/cycle/integrate.hpp"
#include "firmware/cycle/judge.hpp"

namespace spindle_twin::firmware {

/// The correction law and what the cycle tells of it.
struct Corrector {
  std::optional<correction::PaperCorrection> law;
  rom::CorrectionFactors none;  ///< all 1
  Eigen::VectorXd measured_K;   ///< per key point
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
  bool enabled = false;
  std::uint16_t corrections = 0;
};

/// Allocates. Throws rom::InputError for an option out of range.
Corrector make_corrector(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper);

/// Gives the law the measured and predicted key points of this instant; sets the model's state when the law rescales
/// it, and returns the factors for the coming advance_s: the law's, all 1 while the correction is off.
/// Neither switching moves a temperature. Off, the law stands by with the factors that the model runs with; on, it
/// starts from these, all 1, and corrects first after a whole period.
/// Runs in the cycle, no allocation.
const rom::CorrectionFactors& correct(const SensedInputs& sensed, const Judgement& judgement,
                                      const rom::OperatingState& operating, double time_s, double advance_s,
                                      Model& model, Corrector& corrector);

}  // namespace spindle_twin::firmware
