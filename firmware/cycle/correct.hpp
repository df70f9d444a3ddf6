#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/paper/paper_correction.hpp"
#include "firmware/cycle/integrate.hpp"
#include "firmware/cycle/judge.hpp"

namespace spindle_twin::firmware {

/// The period that begins, model time.
struct Period {
  double start_s = 0.0;
  double advance_s = 0.0;
};

/// What one channel of the estimator takes its readings from.
struct CorrectorChannel {
  std::size_t key_point = 0;
  double interval_s = 0.0;
  std::size_t reader = 0;  ///< key point whose sensor shows this place: the same, or that of the one it is swapped with
  bool reads = false;      ///< then: the reading at hand may be used
  std::int64_t taken_ns = 0;  ///< time of the reading that it took last; 0: none yet
};

/// Measured lengths that went to the estimator.
struct DisplacementsTaken {
  std::uint16_t count = 0;
  long due = 0;  ///< one that was noted goes into the update after so many
  std::array<std::int64_t, slots::deformations> probed_ns{};
};

/// What the law is told of its sensors: per key point, or per channel of the estimator.
struct MeasuredTemperatures {
  Eigen::VectorXd value_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
};

/// The correction law and what the cycle tells of it. At most one of the two laws is there.
struct Corrector {
  std::optional<correction::PaperCorrection> paper;
  std::optional<correction::EstimatorCorrection> estimator;
  bool corrects = false;  ///< there is a law that may be switched on
  bool enabled = false;
  std::uint16_t corrections = 0;
  std::uint16_t freeze = 0;  ///< CorrectionFreeze

  std::vector<CorrectorChannel> channels;  ///< of the estimator
  DisplacementsTaken displacements;
  double clock_rate = 1.0;
  rom::CorrectionFactors none;    ///< all 1
  rom::OperatingState operating;  ///< with what the estimator adds to the environments
  MeasuredTemperatures measured;
};

/// What the model runs with for the coming period.
struct CorrectedInputs {
  const rom::CorrectionFactors& factors;
  const rom::OperatingState& operating;
};

/// Allocates. Throws rom::InputError for an option out of range.
/// `shared` as in Cycle.
Corrector make_corrector(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper,
                         std::shared_ptr<const rom::NetworkOperator> shared = nullptr);

/// Gives the law what was measured and what the model says of this instant; sets the model's state when the law
/// corrects it, and returns the inputs for the coming period: the law's, and those as read with all factors 1 while
/// the correction is off. Neither switching moves a temperature. Off, the law stands by with the inputs that the model
/// runs with; on, it starts from these, and corrects first after a whole period. The estimator takes each reading once.
/// Runs in the cycle, no allocation.
CorrectedInputs correct(const SensedInputs& sensed, const Judgement& judgement, const rom::OperatingState& operating,
                        const Period& period, Model& model, Corrector& corrector);

/// The operating state with what the estimator adds to the environments. Runs in the cycle.
const rom::OperatingState& with_biases(const rom::OperatingState& operating, Corrector& corrector);

/// A measured length for the next update, in deformation output `index` from the reference temperature on. Left
/// out while no estimator corrects, where the output does not exist, and where value or deviation is none
/// (`correction::is_growth`): then false.
/// Runs in the cycle.
bool take_displacement(int index, double value_m, double deviation_m, Corrector& corrector);

/// Whether readings contradict the estimate that corrects, or fit it only with a sensor that is off by more than any
/// is: then it reads another unit or another place, or the model is none of this machine. Runs in the cycle.
bool is_estimate_in_doubt(const Corrector& corrector);

/// Whether a length that was noted before still waits for the estimator's update, which has room for one. Runs in the
/// cycle.
bool waits_for_update(const Corrector& corrector);

/// The same for each probe whose interval has passed and whose reading is new, in range and fresh; one per update.
void take_probes(const CyclePlan& plan, const SensedInputs& sensed, double tare_m, Corrector& corrector);

}  // namespace spindle_twin::firmware
