#include "rom/integrate/coolant_outputs.hpp"

#include <Eigen/LU>

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
  march_coolant(network.segments(), values, rises_K.array() + network.reference_K(), outlets);
  return outlets;
}

Eigen::VectorXd steady_temperatures_K(std::shared_ptr<const NetworkOperator> network, const BoundaryValues& values) {
  const Eigen::Index n = network->nodes();
  RightHandSide rhs(network);
  rhs.hold(values);
  Eigen::MatrixXd matrix(n, n);
  rhs.full(matrix);
  Eigen::VectorXd temperatures_K(n);
  network->to_temperatures(matrix.partialPivLu().solve(rhs.drive()), temperatures_K);
  return temperatures_K;
}

}  // namespace spindle_twin::rom
