#pragma once

#include <memory>

#include "rom/integrate/network_operator.hpp"
#include "rom/integrate/stepper.hpp"

namespace spindle_twin::rom {

/// How exact CVODE is and when it starts its history anew. The defaults keep an hour of a drive cycle with speed jumps
/// within 1e-3 K of the exact solution (tests/rom/steppers_test.cpp).
struct CvodeSettings {
  /// Local error per internal step, capacity-weighted root mean square over the network. > 0.
  double tolerance_K = 2e-6;
  /// A heat, conductance or capacity that changes by more than this share of its larger value between two cycles is a
  /// jump; of a node heat, which may be about 0, the share is of the largest heat of any source or node in the two.
  /// Above it a new start costs fewer steps than carrying the history over the kink; below it the history is worth
  /// more.
  double jump_share = 2e-3;
  /// An environment that changes by more than this between two cycles is a jump.
  double jump_K = 0.05;
  /// Share by which conductances and capacities may differ from those in Newton's matrix when CVODE starts anew; each
  /// iteration of Newton leaves at most that share of the error. CVODE asks for a new matrix when they converge too
  /// slowly. 0: the matrix is of the present ones, and each step conserves heat to rounding, not to the tolerance.
  double tolerated_share = 0.1;
  /// Bound on the work of one advance().
  long max_internal_steps = 5000;
};

/// What the integrator has done since it was made.
struct CvodeCounts {
  long internal_steps = 0;
  long right_hand_sides = 0;
  long decompositions = 0;  ///< of K̃ for Newton's matrix, O(N³) each
  long restarts = 0;
  int last_flag = 0;  ///< CVODE's return value of the last advance(), 0 or positive for success
};

/// CVODE (BDF orders 1 to 3, Newton, analytic Jacobian, NewtonSolver) on dx/dt = −K̃x + u.
/// Created once. The history goes on from cycle to cycle and is dropped (CVodeReInit) only when an input jumps or
/// temperatures are set: dropping it each cycle would pay the small first steps of order 1 again each time.
/// The period's end is a stop time, so no step reaches into the next cycle's inputs.
class CvodeStepper final : public Stepper {
 public:
  /// Starts at the network's reference temperature. Throws std::runtime_error if CVODE cannot be set up. Allocates.
  explicit CvodeStepper(std::shared_ptr<const NetworkOperator> network, const CvodeSettings& settings = {});
  ~CvodeStepper() override;
  CvodeStepper(const CvodeStepper&) = delete;
  CvodeStepper& operator=(const CvodeStepper&) = delete;

  void set_temperatures(const Eigen::VectorXd& temperatures_K) override;

  /// period_s > 0 and finite, else integrator_failed. Values sized as the network's boundaries; node heats and capacity
  /// factors as accepts() says, else refused. Cycle-safe: no heap call after the first, whatever the inputs do, as long
  /// as none of them changes its size.
  StepStatus advance(double period_s, const BoundaryValues& values) override;
  const Eigen::VectorXd& temperatures_K() const override;

  CvodeCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::rom
