#pragma once

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {

/// Whether a heat that no source explains would explain the readings better: a second filter over the estimator's
/// unknowns, fed with all the same readings, in which such heats are open in every thermal group. Evidence for it is
/// −2 ln of the ratio of the likelihoods of the readings (Willsky and Jones, IEEE Trans. AC 21, 1976), with ν the
/// innovations of a filter, one sensor after the other, and V their variances:
///   J = Σ min(ν²/V, 9) of one update,   evidence ← e^(−Δt/τ) evidence + J_estimator − J_open,   τ = 1 h
/// What the wider filter should pay for expecting more is left out: the errors of a minute count as one in V, which
/// makes V too large to be weighed against ν². So the evidence of a healthy spindle rises too, to some 40 within two
/// hours (family nominal of tests/bench/reality_campaign), and the limit lies at 60: only a strong heat reaches it. The
/// estimator keeps the heats shut until there is evidence: open, they would cost a spindle without any a third of its
/// accuracy (tests/bench/reality_campaign, family nominal). No allocation after construction; may run in the cycle: one
/// more filter beside those of LeaveOneOut.
class UnexplainedHeat {
 public:
  explicit UnexplainedHeat(const EstimatorCorrection& estimator);

  /// The second filter becomes the estimator's own with the heats open, after it was reset, restored, loosened or
  /// switched on, or has taken over another filter.
  void follow(const EstimatorCorrection& estimator);
  /// After each update of the estimator. True: there is evidence enough, and EstimatorCorrection::open_heats() is due,
  /// with filter() to adopt.
  bool update(const EstimatorCorrection& estimator);

  double evidence() const { return evidence_; }
  const SquareRootFilter& filter() const { return filter_; }

 private:
  SquareRootFilter filter_;
  double evidence_ = 0.0;
  Eigen::VectorXd keep_, growth_, row_;
};

}  // namespace spindle_twin::correction
