#pragma once

#include <Eigen/Core>

#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom {

/// 1/λ of K v = λ C v at conductances g, slowest first [s], N of them; infinity for a mode that no environment ends.
/// An eigendecomposition: not for the cycle.
Eigen::VectorXd time_constants_s(const NetworkOperator& network, const Eigen::VectorXd& conductance_W_per_m2K);

}  // namespace spindle_twin::rom
