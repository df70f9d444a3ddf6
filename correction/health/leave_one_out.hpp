#pragma once

#include <array>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {

/// What all other sensors say of one.
struct Misfit {
  bool judged = false;       ///< the sensor had a valid reading at the last update
  double misfit_K = 0.0;     ///< reading − what the others predict
  double deviation_K = 1.0;  ///< 1σ of that
  double evidence = 0.0;     ///< that its readings do not fit those of all others; about 0 to 10 for a healthy sensor
  double ratio() const { return judged ? misfit_K / deviation_K : 0.0; }
};

/// A bank of filters over (θ, b), one per sensor, each fed with all sensors but its own (multiple-model fault
/// isolation). They share the estimator's model and sensitivities S, and are linear around the estimator's θ:
///   prediction of filter s at sensor j     L_j T + h_j (θ_s − θ) + b_s,j
///   misfit of sensor s                     y_s − L_s T − h_s (θ_s − θ) − b_s,s,     σ² = [h_s, 1] P_s [h_s, 1]ᵀ +
///   noise
/// A slow fault of s shows in its own misfit as far as the others can tell what s should read. How sure the fault is,
/// and whose, is told by the whole history (generalised likelihood ratio: Willsky and Jones, IEEE Trans. AC 21, 1976).
/// With ν the innovations of a filter, one sensor after the other, and V their variances:
///   J = Σ min(ν² / V, 9)  of one update,      evidence_s ← e^(−Δt / τ) evidence_s + J_all − J_without s
/// By the chain rule of probabilities that is −2 ln of how likely the readings of s were, given those of all others. A
/// filter that follows a drift with its parameters has small innovations, but at every update they are larger than
/// those of the filter that never saw the sensor. τ is the time since the start, at most an hour, so that what the
/// first minutes say against the priors fades. The bound of 9 keeps one update from deciding alone.
///   When s has failed, its filter is what the estimator would be had it never seen s: the estimator can go over to it
/// (EstimatorCorrection::adopt).
class LeaveOneOut {
 public:
  /// All filters begin at the estimator's prior. Allocates; nothing else here does.
  explicit LeaveOneOut(const EstimatorCorrection& estimator);

  /// All filters become copies of the estimator's own, and all evidence is dropped; after the estimator was reset,
  /// restored, switched on or changed. May run in the cycle.
  void follow(const EstimatorCorrection& estimator);
  /// The same after the estimator was loosened, but before() still gives what was before that: it was not wrong where
  /// two sensors turn out to be swapped. May run in the cycle.
  void follow_loosened(const EstimatorCorrection& estimator);
  /// Takes the estimator's last update into all filters; once after each. May run in the cycle: m (m − 1) rank-one
  /// updates and m Cholesky factors of m sensors.
  void update(const EstimatorCorrection& estimator);
  /// The sensor's offset may have changed by deviation_K (1σ): together with EstimatorCorrection::widen_offset. May run
  /// in the cycle.
  void widen_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double deviation_K);
  /// The readings of a sensor are lower by shift_K from now on, because a tare was taken. May run in the cycle.
  void shift_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double shift_K);
  /// The sensor failed and the estimator went over to its filter: all others become copies of it, and all evidence is
  /// dropped. May run in the cycle.
  void settle_on(Eigen::Index sensor);

  /// The estimator's filter as it was 10 to 15 minutes ago, or at the last follow() or settle_on() if that is less,
  /// with the uncertainty of the time since added. For two sensors that failed together: no filter has done without
  /// both. Valid until the next call. May run in the cycle.
  const SquareRootFilter& before(const EstimatorCorrection& estimator);

  /// How much it is open whether a sensor has failed: from 0 to 1 as the evidence goes from 4 to 12. May run in the
  /// cycle.
  static double weight_of(double evidence);
  /// For EstimatorCorrection::set_alternatives, p x (sensors + 1): √w (θ_s − θ), w that weight; the last column is
  /// zero, a place for a filter that is kept elsewhere (SecondOpinion). As long as it is open whether s has failed, the
  /// truth may lie where its filter says (solution separation, the protection level of satellite navigation: Brown and
  /// McBurney, Navigation 35, 1988). Valid until the next call. May run in the cycle.
  Eigen::MatrixXd& alternatives(const EstimatorCorrection& estimator);

  /// The judged sensor with most evidence against it, of at least `least`; -1: none. May run in the cycle.
  Eigen::Index most_doubtful(double least) const;
  /// Of the last update.
  const Misfit& misfit(Eigen::Index sensor) const { return misfits_[static_cast<std::size_t>(sensor)]; }
  /// The filter that never saw the sensor.
  const SquareRootFilter& without(Eigen::Index sensor) const { return filters_[static_cast<std::size_t>(sensor)]; }

 private:
  /// The estimator's filter as it was once.
  struct Kept {
    SquareRootFilter filter;
    double age_s = 0.0;
  };
  /// Takes the last update into the filter without the sensor; gives its J.
  double update_one(const EstimatorCorrection& estimator, Eigen::Index sensor);
  void begin_anew(const EstimatorCorrection& estimator);
  void keep_all(const SquareRootFilter& filter);

  std::vector<SquareRootFilter> filters_;
  std::array<Kept, 3> kept_;  // the newest first
  double age_s_ = 0.0;        // since follow()
  SquareRootFilter before_;
  std::vector<Misfit> misfits_;
  Eigen::VectorXd keep_, growth_, row_;
  Eigen::MatrixXd alternatives_;
};

}  // namespace spindle_twin::correction
