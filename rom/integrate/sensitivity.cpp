#include "rom/integrate/sensitivity.hpp"

#include <Eigen/LU>

#include "rom/integrate/right_hand_side.hpp"

namespace spindle_twin::rom {

SteadySensitivities steady_sensitivities(const std::shared_ptr<const NetworkOperator>& coordinates,
                                         const BoundaryValues& given, const Eigen::VectorXd& temperatures_K,
                                         const Eigen::VectorXd& row) {
  BoundaryValues inputs = given;
  inputs.capacity_factor.resize(0);  // of no effect on a steady state
  const Eigen::Index n = coordinates->nodes();
  RightHandSide rhs(coordinates);
  Eigen::MatrixXd matrix(n, n);
  Eigen::VectorXd state(n), residual(n), moved(n);
  coordinates->to_internal(temperatures_K, state);
  rhs.follow(inputs, state.data());
  rhs.linearise(state.data(), matrix);
  BoundaryValues values = inputs;
  if (inputs.laws.follow) coordinates->laws().at_temperatures(temperatures_K, values);
  rhs.hold(values);
  // In internal coordinates y = (L⁻¹ row) · x.
  const Eigen::VectorXd internal_row = coordinates->capacity_root().triangularView<Eigen::Lower>().solve(row);
  const Eigen::VectorXd adjoint = matrix.transpose().partialPivLu().solve(internal_row);
  rhs.evaluate(state.data(), residual.data());

  SteadySensitivities result;
  result.conductance.resize(coordinates->conductances());
  // f is affine in g except along coolant circuits, so a difference quotient of f is exact there to rounding.
  constexpr double nudge = 1e-6;
  for (Eigen::Index j = 0; j < result.conductance.size(); ++j) {
    BoundaryValues nudged = values;
    nudged.conductance_W_per_m2K[j] *= 1.0 + nudge;
    rhs.hold(nudged);
    rhs.evaluate(state.data(), moved.data());
    result.conductance[j] = adjoint.dot(moved - residual) / nudge;
  }
  rhs.hold(values);
  result.heat.resize(values.heat_W.size());
  const Eigen::VectorXd held = rhs.drive();
  for (Eigen::Index i = 0; i < result.heat.size(); ++i) {
    BoundaryValues doubled = values;
    doubled.heat_W[i] *= 2.0;
    rhs.hold(doubled);
    result.heat[i] = adjoint.dot(rhs.drive() - held);
  }
  return result;
}

}  // namespace spindle_twin::rom
