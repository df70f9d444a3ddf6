#include "rom/integrate/coolant_outputs.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "rom/integrate/right_hand_side.hpp"

namespace spindle_twin::rom {

CoolantOutlets coolant_outlets(const NetworkOperator& network, const BoundaryValues& values,
                               const Eigen::VectorXd& temperatures_K) {
  CoolantOutlets outlets;
  outlets.outlet_K = outlets.heat_W = Eigen::VectorXd::Zero(network.circuits());
  if (network.circuits() == 0) return outlets;
  Eigen::VectorXd x(network.nodes());
  network.to_internal(temperatures_K, x);
  const Eigen::VectorXd rises_K = (network.walls().transpose() * x).cwiseQuotient(network.segments().area_m2);
  BoundaryValues now = values;
  if (values.laws.follow) network.laws().at_temperatures(temperatures_K, now);
  march_coolant(network.segments(), now, rises_K.array() + network.reference_K(), outlets);
  return outlets;
}

Eigen::VectorXd steady_temperatures_K(const std::shared_ptr<const NetworkOperator>& network,
                                      const BoundaryValues& values) {
  const Eigen::Index n = network->nodes();
  RightHandSide rhs(network);
  rhs.hold(values);
  Eigen::MatrixXd matrix(n, n);
  rhs.full(matrix);
  Eigen::VectorXd state = matrix.partialPivLu().solve(rhs.drive());
  if (rhs.follow(values, state.data()); rhs.following()) {
    // Newton from the laws held. Where it would go further than a step before, half the way is enough to come near.
    Eigen::VectorXd rate(n), step(n);
    double before = std::numeric_limits<double>::infinity(), part = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      rhs.evaluate(state.data(), rate.data());
      rhs.linearise(state.data(), matrix);
      step = matrix.partialPivLu().solve(rate);
      const double size = step.norm();
      part = size < before ? std::min(1.0, 2.0 * part) : 0.5 * part;
      before = size;
      state += part * step;
      if (!(size > 1e-12 * (state.norm() + network->internal_per_kelvin()))) break;
    }
  }
  Eigen::VectorXd temperatures_K(n);
  network->to_temperatures(state, temperatures_K);
  return temperatures_K;
}

}  // namespace spindle_twin::rom
