#pragma once

#include "correction/estimator/estimator_correction.hpp"
#include "correction/health/leave_one_out.hpp"
#include "correction/health/limits.hpp"

namespace spindle_twin::correction {

/// Whom the readings contradict: of a sensor that evidence blames, it or the model.
enum class Opinion { pending, undecided, against_model, against_sensor };

/// The filter without the sensor that evidence blames first, kept while the blame is laid to the model: the estimate is
/// loosened then, follows that sensor, and with it a drift. Who was right shows in what comes next, with J as in
/// leave_one_out.hpp (a sequential test of two hypotheses: Wald, Ann. Math. Stat. 16, 1945):
///   evidence ← e^(−Δt/τ) evidence + J_estimator − J_kept,   τ = 1 h
/// The kept filter was not loosened and has never seen the sensor. Where the spindle has changed, the other sensors
/// contradict it, and the evidence falls; where the sensor drifts it says what they read, and the evidence grows by
/// what the loosened estimate misses.
///   It is linear around the estimator's θ. What the estimator takes for its new start, or gives up, has gone into the
/// state that both share. No allocation after construction; may run in the cycle: one more filter beside those of
/// LeaveOneOut.
class SecondOpinion {
 public:
  explicit SecondOpinion(const EstimatorCorrection& estimator);

  /// The sensor is blamed, and the estimate has just been loosened or is going to be at its next update; of `bank`,
  /// which has not been, the filter without it is kept.
  void begin(Eigen::Index sensor, const LeaveOneOut& bank);
  void drop() { sensor_ = -1; }
  /// After each update of the estimator, whether there is an opinion or not.
  void update(const EstimatorCorrection& estimator);
  /// `again`: the readings have contradicted the loosened estimate too. Against the sensor where evidence is above
  /// drift_lead, or above zero with `again`, opinion_least_s after the beginning at the earliest; against the model
  /// where it is below −12, odds of e^6. Undecided after second_opinion_s; pending without an opinion.
  Opinion conclude(bool again, const HealthLimits& limits) const;

  /// As those of LeaveOneOut.
  void widen_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double deviation_K);
  void shift_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double shift_K);
  /// Into the last column of the alternatives (LeaveOneOut), which stays zero without an opinion: √w (θ_kept − θ), w
  /// from 1 to 0 as the evidence goes from −4 to −12, and no more than LeaveOneOut has for the evidence of the
  /// beginning and what has come since. As long as it is pending the truth may lie where the kept filter says, or where
  /// the one that LeaveOneOut has without that sensor by now.
  void put_alternative(const EstimatorCorrection& estimator, Eigen::MatrixXd& alternatives) const;

  Eigen::Index sensor() const { return sensor_; }  ///< -1: there is no opinion pending
  /// What the kept filter says of the sensor, and the evidence against that.
  const Misfit& misfit() const { return misfit_; }
  const SquareRootFilter& filter() const { return filter_; }

 private:
  Eigen::Index sensor_ = -1;
  SquareRootFilter filter_;
  Misfit misfit_;
  double begun_with_ = 0.0;  // evidence
  double age_s_ = 0.0;
  bool is_new_ = false;
  long loosened_ = 0;  // of the estimator, when it was looked at last
  Widths closed_;      // of the estimator before it was loosened last
  Widths widths_;      // of the kept filter
  Eigen::VectorXd keep_, growth_, row_;
};

}  // namespace spindle_twin::correction
