#pragma once

#include <Eigen/Core>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// Whether the machine is one of those that the prior and the network speak of, by two reduced chi-squares. That of the
/// parameters, with θ0 and σ0 those of a machine that nobody has tested, over the ln factors of heats, contacts, films
/// and capacities:
///   χ² = Σ (θ_i − θ0_i)² / σ0_i²,   ν = Σ max(0, 1 − P_ii / σ0_i²), the largest since the start
/// ν is the effective number of parameters that readings have determined, and the mean of χ² over the machines of the
/// prior, whatever readings have told: E (θ̂ − θ0)² = σ0² − P. Where a cause that no parameter has goes into those that
/// there are, they lie further out, and P is too small: it counts χ²/ν times (Birge, Phys. Rev. 40, 1932, of
/// measurements that do not agree). The largest ν, since what a loosening opens is no less determined by what was read
/// before; below 1 nothing is said.
/// That of the readings, where no parameter takes that cause: D² = Σ (noise² + floor²) / Σ (noise² + least floor²) over
/// the sensors, with the floor that their innovations show (Consistency) and the least one, which the network is known
/// to be wrong by. What readings determined is D times less sure then, and what they did not as sure as before: 1σ
/// counts √D times, the geometric mean of both. All may run in the cycle.
class ReducedChiSquare {
 public:
  /// Nothing is determined.
  void restart() { *this = {}; }
  /// With the parameters and their covariance as they are now; `of_readings`: D².
  void note(const ParameterModel& parameters, const SquareRootFilter& filter, double of_readings = 1.0);

  /// √(χ²/ν) √D, each at least 1: what 1σ of every output counts times.
  double scale_factor() const { return scale_factor_; }
  /// ν.
  double determined() const { return determined_; }
  /// As of an earlier run; not negative.
  void set_determined(double parameters) { determined_ = parameters; }

 private:
  double determined_ = 0.0;
  double scale_factor_ = 1.0;
};

/// Whether χ² of a filter's parameters, with the ν of now, is more than one machine in a thousand has: above the
/// quantile of that by Wilson and Hilferty (PNAS 17, 1931), of ν = 1 at least. Where priors have shared causes the
/// tail is longer, and more machines are. May run in the cycle.
bool is_unlikely_machine(const ParameterModel& parameters, const SquareRootFilter& filter);

}  // namespace spindle_twin::correction
