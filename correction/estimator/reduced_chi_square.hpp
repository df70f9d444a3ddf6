#pragma once

#include <Eigen/Core>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// Whether the machine is one of those that the prior and the network speak of, by two reduced chi-squares. That of the
/// parameters, with θ0 and σ0 those of a machine that nobody has tested, over the ln factors of heats, contacts, films
/// and capacities:
///   χ² = Σ (θ_i − θ0_i)² / σ0_i²,   ν = Σ max(0, 1 − P_ii / σ0_i²), the largest since the start and at least 1
/// ν is how many factors readings have determined, and the mean of χ² over the machines of the prior, whatever readings
/// have told: E (θ̂ − θ0)² = σ0² − P. Where a cause that no parameter has goes into those that there are, they lie
/// further out, and so P is too small: it counts χ²/ν times (Birge, Phys. Rev. 40, 1932, of measurements that do not
/// agree). The largest ν, since what a loosening opens is no less determined by what was read before.
/// That of the readings, where no parameter takes that cause: Σ (noise² + floor²) / Σ (noise² + least floor²) over the
/// sensors, with the floor that their innovations show (Consistency) and the least one, which the network is known to
/// be wrong by. With D its root, what readings determined is D times less sure, and what they did not as sure as
/// before: 1σ counts √D times, half the way. All may run in the cycle.
class ReducedChiSquare {
 public:
  /// Nothing is determined.
  void restart() { *this = {}; }
  /// With the parameters and their covariance as they are now, and the reduced chi-square of the readings.
  void note(const ParameterModel& parameters, const Eigen::VectorXd& theta, const SquareRootFilter& filter,
            double of_readings = 1.0);

  /// √(χ²/ν) √D, each at least 1: what 1σ of every output counts times.
  double excess() const { return excess_; }
  /// ν.
  double determined() const { return determined_; }
  /// As of an earlier run; not negative.
  void set_determined(double factors) { determined_ = factors; }

 private:
  double determined_ = 0.0;
  double excess_ = 1.0;
};

/// χ²/ν of the parameters of a filter, with the ν of now. May run in the cycle.
double reduced_chi_square(const ParameterModel& parameters, const SquareRootFilter& filter);

}  // namespace spindle_twin::correction
