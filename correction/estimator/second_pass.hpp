#pragma once

#include <Eigen/Core>
#include <memory>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/estimator/reading_record.hpp"
#include "rom/integrate/cvode_stepper.hpp"

namespace spindle_twin::correction {

/// Goes through recorded readings again. A filter takes each reading as linear about what it knew at that moment. In
/// the first minutes, while heats and contacts are open and readings are strong, that can send a bearing's heat and its
/// contact to opposite ends, and later readings, by then believed less than the estimate, do not bring them back. So
/// what the estimator was given is recorded from its start on, and at three ages of the record it is gone through
/// again, beside the cycle, by a second filter and a second model (Gauss and Newton's step over all readings at once:
/// the iterated Kalman filter; Bell and Cathey, IEEE Trans. AC 38, 1993):
///   z̃       where the estimate has arrived; model, S and rows are those of z̃ from the start on
///   z, P    from those of the start on, with v = y − h(z̃) − h' (z − z̃), no noise for curvature
///   z̃ ← z   until no ln factor has moved by more than 0.1, three times at most: Gauss and Newton converge slowly where
///           what is left of the readings is large, as where no constant parameters fit them (a grease that settles)
/// Then the estimate goes over to the result. Nothing is taken where readings contradict it, it does not settle, or it
/// misses the last readings by more than they and the network are wrong. A few recorded seconds are gone through in
/// each cycle, as a multiple of its length and after a pause no more than 200 s of them, so that the same history gives
/// the same result to the bit.
class SecondPass {
 public:
  /// `network` must outlive this. `like`: an estimator of the same network and options. Allocates; nothing else does.
  SecondPass(const rom::Network& network, EstimatorOptions options,
             std::shared_ptr<const rom::NetworkOperator> coordinates, const EstimatorCorrection& like);

  /// The estimate is another than the one that the record is of: the next sample begins a new one.
  void begin_anew();
  /// The estimator was given a length, for its next update.
  void note_displacement(int index, double value_m, double deviation_m) {
    record_.note_displacement({index, value_m, deviation_m});
  }

  /// After the estimator has taken in the sample; `updated`: with an update. True, only with an update: result() is at
  /// the same instant, and the estimate goes over to it.
  bool follow(const EstimatorCorrection& estimator, const EstimatorSample& sample, bool updated);
  const EstimatorCorrection& result() const { return pass_; }

 private:
  void begin_pass();
  void go_on(double elapsed_s, const rom::OperatingState& now);
  void go_through(std::size_t entry, const rom::OperatingState& after);
  bool conclude();
  bool fits() const;
  void end_passes();

  const rom::Network* network_;
  double times_as_fast_;
  EstimatorCorrection pass_;
  rom::CvodeStepper stepper_;
  rom::BoundaryValues values_;
  rom::OperatingState corrected_;
  ReadingRecord record_;
  EstimatorCorrection::Instant start_;
  Eigen::VectorXd unknowns_;  ///< z̃ of the next pass
  Eigen::Array<bool, Eigen::Dynamic, 1> valid_;
  std::size_t next_age_ = 0, next_entry_ = 0;
  int passes_ = 0;
  double due_s_ = 0.0;  ///< of the record, still to be gone through
  double seen_s_ = 0.0;
  bool is_recording_ = false, is_passing_ = false, failed_ = false;
};

}  // namespace spindle_twin::correction
