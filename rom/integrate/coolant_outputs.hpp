#pragma once

#include <Eigen/Core>
#include <memory>

#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::rom {

/// Outlet temperature and heat taken of every circuit at these node temperatures; empty without circuits. Allocates.
CoolantOutlets coolant_outlets(const NetworkOperator& network, const BoundaryValues& values,
                               const Eigen::VectorXd& temperatures_K);

/// Node temperatures after an endless time with these inputs held: K̃x − PX̃Pᵀx = u, with physical laws at their own
/// temperatures by Newton's method. Not finite where nothing leads to an
/// environment. An LU factorisation: not for the cycle.
Eigen::VectorXd steady_temperatures_K(const std::shared_ptr<const NetworkOperator>& network,
                                      const BoundaryValues& values);

}  // namespace spindle_twin::rom
