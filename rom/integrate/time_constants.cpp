#include "rom/integrate/time_constants.hpp"

#include <Eigen/Eigenvalues>
#include <limits>
#include <stdexcept>

namespace spindle_twin::rom {

Eigen::VectorXd time_constants_s(const NetworkOperator& network, const Eigen::VectorXd& conductance_W_per_m2K) {
  Eigen::VectorXd packed = network.make_packed();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(network.nodes(), network.nodes());
  network.assemble(conductance_W_per_m2K, packed, lower);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(lower, Eigen::EigenvaluesOnly);
  if (modes.info() != Eigen::Success) throw std::runtime_error("the network's eigenvalues did not converge");
  const double rounding = 1e-13 * modes.eigenvalues().tail(1)[0];
  return modes.eigenvalues().unaryExpr(
      [rounding](double rate) { return rate > rounding ? 1.0 / rate : std::numeric_limits<double>::infinity(); });
}

}  // namespace spindle_twin::rom
