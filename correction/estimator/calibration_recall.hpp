#pragma once

#include <Eigen/Core>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// Keeps what a test has told over months of service. ln factors wander (their walk), and of those that no permanent
/// sensor sees the deviation would grow for ever: after some weeks nothing would be left of the test. So the calibrated
/// prior N(m, P₀) is taken in again, slowly: with the walk q = diag(w_i²) it gives per second the information
///   S = D^½ P₀⁻¹ D^½,  D = diag(w_i² / (k² P₀ᵢᵢ)),  k = 2
/// and where nothing else is measured, P S P = q: the variance of a parameter ends at k P₀ᵢᵢ. Parameters whose readings
/// say more are pulled by no more than the share of what they know less.
/// Taken in row by row, one an update: S = AᵀA, A = L⁻¹ D^½, P₀ = L Lᵀ.
class CalibrationRecall {
 public:
  CalibrationRecall() = default;
  /// Of the calibrated parameters of the model; none without a calibration. `unknowns`: size of the filter. Allocates.
  CalibrationRecall(const ParameterModel& parameters, Eigen::Index unknowns);

  /// One row for the time that has passed, of as many rows as there are: innovation a (m − z), variance 1/(rows Δt).
  /// The state is not corrected with it: what is recalled is where parameters are going, not where they were. May run
  /// in the cycle.
  void take_in(double elapsed_s, SquareRootFilter& filter);

 private:
  Eigen::MatrixXd rows_;  // of A, on z, one a column
  Eigen::VectorXd mean_, row_;
  Eigen::Index next_ = 0;
};

}  // namespace spindle_twin::correction
