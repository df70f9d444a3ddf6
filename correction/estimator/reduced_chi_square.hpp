#pragma once

#include <Eigen/Core>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// Whether the machine is one of those that the prior speaks of. With θ0 and σ0 those of a machine that nobody has
/// tested, over the ln factors of heats, contacts, films and capacities:
///   χ² = Σ (θ_i − θ0_i)² / σ0_i²,   ν = Σ max(0, 1 − P_ii / σ0_i²), the largest since the start and at least 1
/// ν is how many factors readings have determined, and the mean of χ² over the machines of the prior, whatever readings
/// have told: E (θ̂ − θ0)² = σ0² − P. Where a cause that no parameter has goes into those that there are, they lie
/// further out, and so P is too small: it counts χ²/ν times then (Birge, Phys. Rev. 40, 1932, of measurements that do
/// not agree). The largest ν, since what a loosening opens is no less determined by what was read before. All may run
/// in the cycle.
class ReducedChiSquare {
 public:
  /// Nothing is determined.
  void restart() { *this = {}; }
  /// With the parameters and their covariance as they are now.
  void note(const ParameterModel& parameters, const Eigen::VectorXd& theta, const SquareRootFilter& filter);

  /// √(χ²/ν), at least 1: what 1σ of every output counts times.
  double excess() const { return excess_; }
  /// ν.
  double determined() const { return determined_; }
  /// As of an earlier run; not negative.
  void set_determined(double factors) { determined_ = factors; }

 private:
  double determined_ = 0.0;
  double excess_ = 1.0;
};

}  // namespace spindle_twin::correction
